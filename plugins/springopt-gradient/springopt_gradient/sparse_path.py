"""One spring fewer at a time: the path of misfit against number of springs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from springopt.checks import Booleans, Floats, require_positive
from springopt.errors import NoEquilibrium, NotServed, UserError
from springopt.optimizer import Optimizer
from springopt.problem import Problem
from springopt_gradient.descent import Linearization, descend, linearize
from springopt_gradient.gauss_newton import GaussNewton
from springopt_gradient.measures import Measure, measures_of
from springopt_gradient.memory import require_memory

#: Numbers below this share of the box count as zero.
NEGLIGIBLE = 1e-6
#: Holds what no load case sees, in units of the mean curvature.
HOLD = 1e-9


@dataclass(frozen=True)
class SparsePath(Optimizer):
    """From the best point of gauss-newton on, the number that matters least becomes zero and the others are refitted.

    What matters least is told by the curvature, as in the optimal brain surgeon of Hassibi and Stork (1993): zeroing
    number i costs x_i^2 / (2 inverse_ii) once the others have moved. Each refitted point goes to the problem's front.
    """

    name: ClassVar[str] = "sparse-path"
    needs: ClassVar[tuple[str, ...]] = ("real", "jacobian")
    fewest: int = 1  #: numbers above zero with which the path ends
    agree: int = 3  #: the option of gauss-newton, which finds where the path begins
    tolerance: float = 1e-4  #: a refit ends when less than this share of the value can be gained

    def __post_init__(self) -> None:
        if self.fewest < 1:
            raise UserError(f"option fewest of sparse-path is at least 1, not {self.fewest}; give a larger number.")
        require_positive("option tolerance of sparse-path", self.tolerance)

    def minimize(self, problem: Problem, rng: np.random.Generator) -> None:
        if problem.encoding.parameter_count:
            raise NotServed(
                "sparse-path makes numbers zero, one after the other, and this scene fits parameters of effects beside "
                "the springs; leave encoding.parameters out, or use gauss-newton.",
                word="parameters",
            )
        if problem.lower.any():
            raise NotServed(
                "sparse-path needs numbers that can be zero; give the scene's encoding a lower bound of 0.", word="zero"
            )
        require_memory(self.name, problem)
        GaussNewton(agree=self.agree).minimize(problem, rng)
        measure, best = measures_of(problem)[-1], problem.best_point
        assert best is not None
        here: Linearization | None = linearize(problem, best)
        while here:
            problem.objectives(here.point[None])
            present = here.point > 0
            problem.note(numbers=int(present.sum()))
            if present.sum() <= self.fewest:
                return
            here = self._shorter(problem, measure, here)

    def _shorter(self, problem: Problem, measure: Measure, here: Linearization) -> Linearization | None:
        """Refitted without the negligible numbers or, if there is none, without one more; None if none can go."""
        for gone, point in _candidates(problem, measure, here):
            upper = np.where(gone, 0.0, problem.upper)
            try:
                there = linearize(problem, np.clip(point, 0.0, upper))
            except NoEquilibrium:
                continue
            return descend(problem, there, measure, tolerance=self.tolerance, upper=upper)
        return None


def _candidates(problem: Problem, measure: Measure, here: Linearization) -> Iterator[tuple[Booleans, Floats]]:
    """What may become zero, shape (size,), and where the others then might be, the cheapest first."""
    absent, negligible = here.point == 0, here.point <= NEGLIGIBLE * problem.upper
    if (negligible & ~absent).any():
        yield negligible, here.point
    present = np.flatnonzero(~negligible)
    shares = (here.point / problem.upper)[present]
    inverse = _inverse(measure.curvature(here.residuals, here.jacobian[:, present]))
    for i in np.argsort(shares**2 / np.diag(inverse), kind="stable"):
        gone, moved = absent.copy(), here.point.copy()
        gone[present[i]] = True
        moved[present] -= problem.upper[present] * inverse[:, i] * shares[i] / inverse[i, i]
        yield gone, moved
        yield gone, here.point


def _inverse(curvature: Floats) -> Floats:
    held = curvature + HOLD * (np.diag(curvature).mean() or 1.0) * np.eye(len(curvature))
    return cho_solve(cho_factor(held), np.eye(len(held)))
