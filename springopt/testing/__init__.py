"""What plugin authors import to test their plugin: `check_optimizer(MyOptimizer)`."""

from springopt.testing.bowl import Bowl, Box
from springopt.testing.cliff import Cliff
from springopt.testing.optimizer_checks import CHECKS, check_optimizer, examine
from springopt.testing.tape import Tape
from springopt.testing.verdict import Finding, NotJudged

__all__ = ["CHECKS", "Bowl", "Box", "Cliff", "Finding", "NotJudged", "Tape", "check_optimizer", "examine"]
