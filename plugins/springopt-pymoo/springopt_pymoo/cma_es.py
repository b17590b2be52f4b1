"""pymoo's CMA-ES: the covariance matrix adaptation of Hansen and Ostermeier (2001), by Hansen's package cma."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from springopt.optimizer import Optimizer
from springopt.problem import Problem
from springopt_pymoo.ranges import require_options

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
        from springopt_pymoo.cma_box import CmaBox, SeededCMAES
        from springopt_pymoo.search import search

        scene = CmaBox(problem)
        algorithm = SeededCMAES(
            scene.individuals(problem.sample(rng, self.first)),
            rng,
            sigma=self.sigma,
            pop_size=self.population,
            restarts=RESTARTS,
            incpopsize=self.growth,
            bipop=self.bipop,
        )
        search(algorithm, scene, rng)
