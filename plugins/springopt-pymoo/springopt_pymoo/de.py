"""pymoo's differential evolution, Storn and Price (1997)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np

from springopt.optimizer import Optimizer
from springopt.problem import Problem
from springopt_pymoo.ranges import require_options


@dataclass(frozen=True)
class DE(Optimizer):
    """Differential evolution of pymoo: trials from differences of individuals, each against its own target."""

    name: ClassVar[str] = "pymoo-de"
    needs: ClassVar[tuple[str, ...]] = ("real",)
    population: int = 100  #: individuals
    base: Literal["best", "rand", "target-to-best"] = "best"  #: what the differences are added to
    differences: Literal[1, 2] = 1  #: how many are added
    crossover: Literal["bin", "exp", "hypercube", "line"] = "bin"  #: which numbers a trial takes from its donor
    F: float = 0.5  #: weight of a difference
    CR: float = 0.2  #: probability of a number to be the donor's

    def __post_init__(self) -> None:
        require_options(self, population=(6, 1e6), F=(0, 2), CR=(0, 1))

    def minimize(self, problem: Problem, rng: np.random.Generator) -> None:
        from pymoo.algorithms.soo.nonconvex import de

        from springopt_pymoo.search import Scene, first_generation, search

        algorithm = de.DE(
            pop_size=self.population,
            sampling=first_generation(problem, rng, self.population),
            variant=f"DE/{self.base}/{self.differences}/{self.crossover}",
            F=self.F,
            CR=self.CR,
        )
        search(algorithm, Scene(problem), rng)
