"""The contract of an optimizer: its options are fields, its work is one method."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Collection
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from springopt.errors import NotServed, PluginError, did_you_mean

if TYPE_CHECKING:
    from springopt.problem import Problem

NEEDS = {
    "binary": "a binary encoding",
    "real": "a real encoding",
    "gradient": "gradients",
    "residuals": "residuals of an encoding with derivatives",
    "jacobian": "the Jacobian of the residuals",
    "objective": "the lattice, load cases and reference behind the numbers",
}


@dataclass(frozen=True)
class Optimizer(ABC):
    """Proposes points until the budget is spent. A subclass is a frozen dataclass whose fields are its options.

    An option has a type, a default and an explanation behind `#:`; illegal values are refused in `__post_init__`
    by a UserError. See `springopt.random_search` for the smallest example and `springopt.testing` for the checks.

    Attributes:
        name: what scenes and the command line call it.
        needs: what it can't do without, of the words in `NEEDS`; a scene that lacks one refuses it.
    """

    name: ClassVar[str]
    needs: ClassVar[Collection[str]] = frozenset()

    @abstractmethod
    def minimize(self, problem: Problem, rng: np.random.Generator) -> None:
        """Asks the problem for values until it is content or `BudgetSpent` ends it; the problem keeps the best.

        It is a deterministic function of the answers and of `rng`, its only source of randomness: runs are resumed
        by running it again with the answers on record. A gradient method survives `NoEquilibrium`.
        """


def require_supplies(optimizer: Optimizer, supplies: Collection[str]) -> None:
    """Refuses an optimizer that needs what a problem does not supply."""
    for need in optimizer.needs:
        if need not in NEEDS:
            raise PluginError(
                f"optimizer {optimizer.name} states an unknown need {need!r}; the needs are {', '.join(NEEDS)}."
                f"{did_you_mean(need, NEEDS)}"
            )
        if need not in supplies:
            raise NotServed(
                f"{optimizer.name} needs {NEEDS[need]}, which this scene does not supply; "
                "choose another optimizer or change the scene.",
                word=need,
            )
