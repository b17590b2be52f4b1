"""What plugin authors import to test their plugin: `check_optimizer(MyOptimizer)`."""

from springopt.testing.bowl import Bowl, Box
from springopt.testing.optimizer_checks import CHECKS, check_optimizer
from springopt.testing.tape import Tape

__all__ = ["CHECKS", "Bowl", "Box", "Tape", "check_optimizer"]
