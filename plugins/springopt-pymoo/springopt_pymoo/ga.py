"""pymoo's genetic algorithm, for numbers and for bits."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from springopt.optimizer import Optimizer
from springopt.problem import Problem
from springopt_pymoo.ranges import require_options


@dataclass(frozen=True)
class GA(Optimizer):
    """Genetic algorithm of pymoo: tournaments of two, and the best of parents and children live on."""

    name: ClassVar[str] = "pymoo-ga"
    population: int = 100  #: individuals
    children: int | None = None  #: individuals that are evaluated each generation; none: as many as the population
    crossover_eta: float = 15.0  #: numbers: the higher, the closer two children are to their parents
    mutation_eta: float = 20.0  #: numbers: the higher, the smaller the steps of mutation

    def __post_init__(self) -> None:
        require_options(self, population=(2, 1e6), children=(1, 1e6), crossover_eta=(0, 1e3), mutation_eta=(0, 1e3))

    def minimize(self, problem: Problem, rng: np.random.Generator) -> None:
        from pymoo.algorithms.soo.nonconvex import ga

        from springopt_pymoo.operators import binary_operators, real_operators
        from springopt_pymoo.search import Survivors, first_generation, search

        is_binary = problem.kind == "binary"
        operators = binary_operators() if is_binary else real_operators(self.crossover_eta, self.mutation_eta)
        algorithm = ga.GA(
            pop_size=self.population,
            n_offsprings=self.children,
            sampling=first_generation(problem, rng, self.population),
            **operators,
        )
        search(algorithm, Survivors(problem), rng)
