"""pymoo's CMA-ES: the covariance matrix adaptation of Hansen and Ostermeier (2001), by Hansen's package cma."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from pymoo.algorithms.soo.nonconvex import cmaes
from pymoo.core.initialization import Initialization

from springopt.checks import Floats
from springopt.optimizer import Optimizer
from springopt.problem import Problem
from springopt_pymoo.search import Scene, require_options, search

RESTARTS = 1000  # more than any budget lasts for, as each is twice as large as the one before


@dataclass(frozen=True)
class CMAES(Optimizer):
    """CMA-ES of pymoo: normal steps whose covariance is learned; begun again twice as large when it has converged."""

    name: ClassVar[str] = "pymoo-cma-es"
    needs: ClassVar[tuple[str, ...]] = ("real",)
    first: int = 20  #: points that are tried to begin at the best of them
    sigma: float = 0.1  #: standard deviation of the first steps, as a share of the box
    population: int | None = None  #: points of a generation; none: 4 + 3 ln(size), as cma has it
    growth: int = 2  #: factor of the population at each new beginning
    bipop: bool = False  #: whether large new beginnings alternate with small ones, as Hansen (2009)

    def __post_init__(self) -> None:
        require_options(self, first=(1, 1e6), sigma=(1e-12, 10), population=(4, 1e6), growth=(1, 100))

    def minimize(self, problem: Problem, rng: np.random.Generator) -> None:
        scene = _Box(problem)
        algorithm = _CMAES(
            scene.individuals(problem.sample(rng, self.first)),
            rng,
            sigma=self.sigma,
            pop_size=self.population,
            restarts=RESTARTS,
            incpopsize=self.growth,
            bipop=self.bipop,
        )
        search(algorithm, scene, rng)


class _CMAES(cmaes.CMAES):
    """Begins at given points, and draws from `rng` alone: cma would seed NumPy's global generator."""

    def __init__(self, first: Floats, rng: np.random.Generator, **options: Any) -> None:
        super().__init__(randn=lambda *shape: rng.standard_normal(shape), **options)
        self.initialization = Initialization(first)

    def _setup(self, problem: Any, **kwargs: Any) -> None:
        super()._setup(problem, **kwargs)
        self.options["seed"] = np.nan


class _Box(Scene):
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
