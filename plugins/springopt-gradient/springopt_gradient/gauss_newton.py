"""Bounded Gauss-Newton with Levenberg-Marquardt damping, from many starts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from springopt.checks import Floats, require_positive
from springopt.optimizer import Optimizer
from springopt.problem import Problem
from springopt_gradient.descent import DAMPING, descend, linearize
from springopt_gradient.measures import measures_of, negligible
from springopt_gradient.memory import require_memory
from springopt_gradient.starts import require_counts, search_from_starts

#: Relative decrease at which least squares hand over to the scene's own misfit.
ROUGH = 1e-3


@dataclass(frozen=True)
class GaussNewton(Optimizer):
    """Solves for the residuals' zero or least squares with their Jacobian, then for the scene's own misfit.

    Levenberg (1944), Marquardt (1963); the box by Portugal, Júdice and Vicente (1994); misfits that are no squares as a
    convex function of residuals that are linear in the step, Burke and Ferris (1995).
    """

    name: ClassVar[str] = "gauss-newton"
    needs: ClassVar[tuple[str, ...]] = ("real", "jacobian")
    starts: int | None = None  #: local searches at most; none: as many as the budget allows
    agree: int = 3  #: ends when so many searches have ended at the best value; 0: never
    damping: float = DAMPING  #: of the first step, in units of the mean curvature
    tolerance: float = 1e-10  #: a local search ends when less than this share of the value can be gained

    def __post_init__(self) -> None:
        require_counts(self.name, self.starts, self.agree)
        require_positive("option damping of gauss-newton", self.damping)
        require_positive("option tolerance of gauss-newton", self.tolerance)

    def minimize(self, problem: Problem, rng: np.random.Generator) -> None:
        require_memory(self.name, problem)
        *rough, last = measures_of(problem)
        value_of = problem.objective.value_of

        def search(start: Floats) -> float:
            here = linearize(problem, start)
            zero = negligible(problem, value_of(here.residuals))
            for measure in rough:
                here = descend(problem, here, measure, tolerance=ROUGH, damping=self.damping)
            if value_of(here.residuals) > zero:
                here = descend(problem, here, last, tolerance=self.tolerance, damping=self.damping)
            reached = value_of(here.residuals)
            return reached if reached > zero else 0.0

        search_from_starts(problem, rng, search, starts=self.starts, agree=self.agree)
