"""Adaptive fidelity: at which tolerance the best of a batch are looked for, loose while their values are spread.

Equilibria by a loose tolerance are found sooner, and values are off by what it leaves out of balance. So the tolerance
follows the spread of the values, by an error that is measured on the scene itself: the first selections, and one in so
many later ones, are made by both tolerances, and compared.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from springopt.checks import Floats
from springopt.race import best_of
from springopt.run import LooseSelections

MEASURED_AT_FIRST = 32  # candidates that are solved by both tolerances before the loose one is trusted
COMPARED = 20  # one selection in so many is made by both
SHARE = 0.01  # of the spread, that the error of a value may have
WINDOW = 16  # values whose spread is looked at, where a batch has fewer


class Plan(NamedTuple):
    """How one selection is made."""

    tolerance: float  #: of the forward solve
    is_loose: bool  #: whether that is above the scene's own
    is_compared: bool = False  #: whether it is made by the scene's own as well, whose values are then given
    error: float = 0.0  #: expected of a value


@dataclass
class Fidelity:
    """What is known of the errors and the spread, and how often selections differed; it changes with each selection.

    It is a function of the outcomes alone, so that a resumed run takes the same decisions.
    """

    own: float  #: the scene's tolerance
    loosest: float  #: that may be used
    loose_count: int = 0  #: selections that were made by a loose tolerance
    compared_count: int = 0  #: of these, made by the scene's own as well
    differing_count: int = 0  #: of these, with other places or in another order
    measured: int = 0  #: candidates whose value is known by both
    error: float = 0.0  #: the largest so far of a value by the loosest tolerance
    spread: float = math.inf  #: of the last values, from the least to the median
    last: tuple[float, ...] = ()  #: values

    @property
    def selections(self) -> LooseSelections | None:
        """How many there were, for the run; None where no tolerance above the scene's own is allowed."""
        if self.loosest <= self.own:
            return None
        return LooseSelections(self.loosest, self.loose_count, self.compared_count, self.differing_count)

    def plan(self) -> Plan:
        """How the next selection is made."""
        if self.loosest <= self.own:
            return Plan(self.own, is_loose=False)
        if self.measured < MEASURED_AT_FIRST:
            return Plan(self.loosest, is_loose=True, is_compared=True, error=math.inf)
        # What is left out of balance is at most in proportion to the tolerance.
        allowed = SHARE * self.spread
        tolerance = self.loosest if self.error <= allowed else self.loosest * allowed / self.error
        if tolerance <= self.own:
            return Plan(self.own, is_loose=False)
        is_compared = self.loose_count % COMPARED == 0
        return Plan(tolerance, is_loose=True, is_compared=is_compared, error=self.error * tolerance / self.loosest)

    def see(self, values: Floats) -> None:
        """Takes notice of the values of a batch, shape (m,); inf where they were dropped."""
        if self.loosest <= self.own:
            return
        found = values[np.isfinite(values)].tolist()
        self.last = tuple([*self.last, *found][-max(WINDOW, len(found)) :])
        if self.last:
            self.spread = float(np.median(self.last)) - min(self.last)

    def learn(self, plan: Plan, values: Floats, loose: Floats, count: int, rivals: Floats) -> None:
        """Takes notice of a loose selection of `count` among values (m,) and rivals (r,), made by the plan.

        `loose` are the values of those that were solved by both tolerances, nan of the others, shape (m,).
        """
        both = np.isfinite(loose) & np.isfinite(values)
        errors = np.abs(values[both] - loose[both]) * (self.loosest / plan.tolerance)
        self.measured += int(both.sum())
        self.error = max(self.error, float(errors.max(initial=0.0)))
        self.loose_count += 1
        if plan.is_compared:
            found, exact = best_of(loose, count, rivals).places, best_of(values, count, rivals).places
            self.compared_count += 1
            self.differing_count += not np.array_equal(found, exact)
