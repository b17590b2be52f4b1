"""SciPy's L-BFGS-B with the adjoint gradient, from many starts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from springopt.checks import Floats
from springopt.errors import NoEquilibrium, UserError
from springopt.optimizer import Optimizer
from springopt.problem import Problem
from springopt_gradient.measures import negligible
from springopt_gradient.starts import require_counts, search_from_starts

#: More than any budget: what ends a search is that it stands still, or the problem.
FOREVER = 10**9
#: A search is taken up again after one that gained at least this share of the value.
WORTH = 1e-2


@dataclass(frozen=True)
class LBFGSB(Optimizer):
    """The limited-memory quasi-Newton method for boxes of Byrd, Lu, Nocedal and Zhu (1995), in shares of the box."""

    name: ClassVar[str] = "l-bfgs-b"
    needs: ClassVar[tuple[str, ...]] = ("real", "gradient")
    starts: int | None = None  #: local searches at most; none: as many as the budget allows
    agree: int = 3  #: ends when so many searches have ended at the best value; 0: never
    memory: int = 20  #: steps that the curvature is learned from
    tolerance: float = 1e-8  #: a local search ends when a step gains less than this share of the value

    def __post_init__(self) -> None:
        require_counts(self.name, self.starts, self.agree)
        if self.memory < 1:
            raise UserError(f"option memory of l-bfgs-b is at least 1, not {self.memory}; give more steps.")

    def minimize(self, problem: Problem, rng: np.random.Generator) -> None:
        def search(start: Floats) -> float:
            descent = Descent(problem, start)
            zero = negligible(problem, descent.value)
            while descent.value > zero and descent.go_on(self.memory, self.tolerance):
                pass
            return descent.value if descent.value > zero else 0.0

        search_from_starts(problem, rng, search, starts=self.starts, agree=self.agree)


class Descent:
    """The way down from a start, in shares of the box and of the value where SciPy took it up last.

    It changes itself: SciPy asks it for values, and it remembers the best. Raises NoEquilibrium if there is none at the
    start; two evaluations.

    Attributes:
        value: the lowest so far, in the problem's own unit.
    """

    def __init__(self, problem: Problem, start: Floats) -> None:
        self._problem, self._size = problem, problem.upper - problem.lower
        self._point = (start - problem.lower) / self._size
        self.value, self._gradient = self._solve(self._point)

    def go_on(self, memory: int, tolerance: float) -> bool:
        """Goes down from the best point until SciPy stops, and says whether that was worth it.

        SciPy's measure of progress is a share of the first value, and its line search may fail; so one more search from
        where it stopped tells whether that was the end.
        """
        from scipy.optimize import minimize

        unit = self.value
        options = {"maxcor": memory, "ftol": tolerance, "gtol": 0.0, "maxiter": FOREVER, "maxfun": FOREVER}
        bounds = [(0.0, 1.0)] * len(self._point)
        minimize(self._ask, self._point, (unit,), "L-BFGS-B", jac=True, bounds=bounds, options=options)
        return self.value < (1 - WORTH) * unit

    def _ask(self, point: Floats, unit: float) -> tuple[float, Floats]:
        """Value and gradient; where there is no equilibrium, of a parabola that leads back to the best point."""
        if np.array_equal(point, self._point):
            return self.value / unit, self._gradient / unit
        try:
            value, gradient = self._solve(point)
        except NoEquilibrium:
            away = point - self._point
            steepness = self.value / (away @ away)
            return 2 * self.value / unit, 2 * steepness * away / unit
        if value < self.value:
            self._point, self.value, self._gradient = point.copy(), value, gradient
            self._problem.note(value=value)
        return value / unit, gradient / unit

    def _solve(self, point: Floats) -> tuple[float, Floats]:
        problem = self._problem
        x = np.clip(problem.lower + self._size * point, problem.lower, problem.upper)
        value, gradient = problem.gradient(x)
        return value, gradient * self._size
