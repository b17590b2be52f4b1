"""What plugin authors import to test their plugin: `check_optimizer(MyOptimizer)`, `check_effect(MyEffect(...))`."""

from springopt.testing.bowl import Bowl, Box
from springopt.testing.cliff import Cliff
from springopt.testing.effect_checks import EFFECT_CHECKS, check_effect, examine_effect
from springopt.testing.optimizer_checks import CHECKS, check_optimizer, examine
from springopt.testing.tape import Tape
from springopt.testing.unraced import Unraced
from springopt.testing.verdict import Finding, NotJudged

__all__ = [
    "CHECKS",
    "EFFECT_CHECKS",
    "Bowl",
    "Box",
    "Cliff",
    "Finding",
    "NotJudged",
    "Tape",
    "Unraced",
    "check_effect",
    "check_optimizer",
    "examine",
    "examine_effect",
]
