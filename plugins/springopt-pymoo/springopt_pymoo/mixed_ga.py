"""pymoo's genetic algorithm for mixed variables: which springs are there, and how stiff they are."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from springopt.optimizer import Optimizer
from springopt.problem import Problem
from springopt_pymoo.ranges import require_options


@dataclass(frozen=True)
class MixedGA(Optimizer):
    """Genetic algorithm of pymoo for mixed variables: a bit for each spring, and its stiffness beside it."""

    name: ClassVar[str] = "pymoo-mixed-ga"
    population: int = 50  #: individuals
    children: int | None = None  #: individuals that are evaluated each generation; none: as many as the population

    def __post_init__(self) -> None:
        require_options(self, population=(2, 1e6), children=(1, 1e6))

    def minimize(self, problem: Problem, rng: np.random.Generator) -> None:
        from pymoo.core.duplicate import DefaultDuplicateElimination
        from pymoo.core.mixed import MixedVariableGA, MixedVariableMating

        from springopt_pymoo.genes import Genes
        from springopt_pymoo.search import search

        scene = Genes(problem)
        # By points: pymoo's own comparison of mixed variables, one by one, would take ten times as long as the solves.
        duplicates = DefaultDuplicateElimination(func=lambda population: scene.points(population.get("X")))
        algorithm = MixedVariableGA(
            pop_size=self.population,
            n_offsprings=self.children,
            sampling=scene.individuals(problem.sample(rng, self.population)),
            mating=MixedVariableMating(eliminate_duplicates=duplicates),
            eliminate_duplicates=duplicates,
        )
        search(algorithm, scene, rng)
