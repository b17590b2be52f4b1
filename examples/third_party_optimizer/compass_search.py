"""Compass search (Kolda, Lewis and Torczon, SIAM Review 45, 2003, section 1.2), as somebody else's optimizer."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from springopt import Optimizer, Problem


@dataclass(frozen=True)
class CompassSearch(Optimizer):
    """A step forth or back along each axis in turn; half as long where none leads down, and begun anew in the end."""

    name: ClassVar[str] = "compass-search"
    needs: ClassVar[tuple[str, ...]] = ("real",)
    first: float = 0.25  #: first step, as a share of each interval
    last: float = 1e-4  #: step after which the search begins anew from another point

    def minimize(self, problem: Problem, rng: np.random.Generator) -> None:
        while problem.budget_left:
            point = problem.sample(rng, 1)[0]
            value, step = problem.evaluate([point])[0], self.first
            while step > self.last:
                before = value
                for axis in np.diag(step * (problem.upper - problem.lower)):
                    trials = np.clip([point + axis, point - axis], problem.lower, problem.upper)
                    values = problem.evaluate(trials)
                    if values.min() < value:
                        point, value = trials[values.argmin()], values.min()
                step *= 1.0 if value < before else 0.5
                problem.note(step=step)
