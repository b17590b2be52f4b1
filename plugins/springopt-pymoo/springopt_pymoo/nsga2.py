"""NSGA-II of Deb, Pratap, Agarwal and Meyarivan (2002): a low value and few springs at once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from springopt.optimizer import Optimizer
from springopt.problem import Problem
from springopt_pymoo.ranges import require_options


@dataclass(frozen=True)
class NSGA2(Optimizer):
    """NSGA-II of pymoo on two goals, the objective and the number of springs; the run keeps the front."""

    name: ClassVar[str] = "nsga2"
    population: int = 100  #: individuals
    crossover_eta: float = 15.0  #: numbers: the higher, the closer two children are to their parents
    mutation_eta: float = 20.0  #: numbers: the higher, the smaller the steps of mutation
    switches: float = 0.3  #: numbers: springs that mutation puts in or takes out of a child, in the mean

    def __post_init__(self) -> None:
        require_options(self, population=(2, 1e6), crossover_eta=(0, 1e3), mutation_eta=(0, 1e3), switches=(0, 1e6))

    def minimize(self, problem: Problem, rng: np.random.Generator) -> None:
        from pymoo.algorithms.moo import nsga2

        from springopt_pymoo.operators import binary_operators
        from springopt_pymoo.search import first_generation, search
        from springopt_pymoo.whole_springs import TwoGoals, spring_operators

        if problem.kind == "binary":
            operators = binary_operators()
        else:
            operators = spring_operators(self.crossover_eta, self.mutation_eta, self.switches / problem.size)
        algorithm = nsga2.NSGA2(
            pop_size=self.population,
            sampling=first_generation(problem, rng, self.population),
            **operators,
        )
        search(algorithm, TwoGoals(problem), rng)
