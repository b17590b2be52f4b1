"""pymoo's CMA-ES as springopt needs it: where it begins, what it draws from, and boxes of a single number."""

from __future__ import annotations

from typing import Any

import numpy as np
from pymoo.algorithms.soo.nonconvex import cmaes
from pymoo.core.initialization import Initialization

from springopt.checks import Floats
from springopt.problem import Problem
from springopt_pymoo.search import Scene


class SeededCMAES(cmaes.CMAES):
    """Begins at given points, and draws from `rng` alone: cma would seed NumPy's global generator."""

    def __init__(self, first: Floats, rng: np.random.Generator, **options: Any) -> None:
        super().__init__(randn=lambda *shape: rng.standard_normal(shape), **options)
        self.initialization = Initialization(first)

    def _setup(self, problem: Any, **kwargs: Any) -> None:
        super()._setup(problem, **kwargs)
        self.options["seed"] = np.nan


class CmaBox(Scene):
    """A box of at least two dimensions, which cma wants: a single number gets an idle companion."""

    def __init__(self, problem: Problem) -> None:
        self.idle = max(0, 2 - problem.size)
        self.lower, self.upper = problem.lower, problem.upper
        xl, xu = np.append(self.lower, np.zeros(self.idle)), np.append(self.upper, np.ones(self.idle))
        super().__init__(problem, n_var=problem.size + self.idle, xl=xl, xu=xu)

    def individuals(self, points: Floats) -> Floats:
        return np.pad(points, ((0, 0), (0, self.idle)))

    def points(self, individuals: Floats) -> Floats:
        # Rounding may leave the box by a bit.
        return np.clip(individuals[:, : len(self.lower)], self.lower, self.upper)
