"""pymoo's genetic algorithm for mixed variables: which springs are there, and how stiff they are."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from pymoo.core.duplicate import DefaultDuplicateElimination
from pymoo.core.mixed import MixedVariableGA, MixedVariableMating
from pymoo.core.population import Population
from pymoo.core.variable import Binary, Real

from springopt.checks import Floats
from springopt.optimizer import Optimizer
from springopt.problem import Problem
from springopt_pymoo.search import Scene, require_options, search


@dataclass(frozen=True)
class MixedGA(Optimizer):
    """Genetic algorithm of pymoo for mixed variables: a bit for each spring, and its stiffness beside it."""

    name: ClassVar[str] = "pymoo-mixed-ga"
    population: int = 50  #: individuals
    children: int | None = None  #: individuals that are evaluated each generation; none: as many as the population

    def __post_init__(self) -> None:
        require_options(self, population=(2, 1e6), children=(1, 1e6))

    def minimize(self, problem: Problem, rng: np.random.Generator) -> None:
        scene = _Mixed(problem)
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


class _Mixed(Scene):
    """Bits of a binary box; of a real one the numbers, and a bit beside each that may be 0: its spring is there.

    Their names are ("number", i) and ("bit", i).
    """

    def __init__(self, problem: Problem) -> None:
        self.lower, self.upper = problem.lower, problem.upper
        is_binary = problem.kind == "binary"
        self.numbers = [] if is_binary else list(range(problem.size))
        self.bits = [i for i in range(problem.size) if is_binary or self.lower[i] == 0.0]
        names = [*(("number", i) for i in self.numbers), *(("bit", i) for i in self.bits)]
        super().__init__(problem, vars={name: self._variable(*name) for name in names})

    def _variable(self, kind: str, i: int) -> Any:
        return Binary() if kind == "bit" else Real(bounds=(self.lower[i], self.upper[i]))

    def individuals(self, points: Floats) -> Any:
        """pymoo's individuals for points, shape (m, size)."""
        genes = [
            {("number", i): point[i] for i in self.numbers} | {("bit", i): bool(point[i]) for i in self.bits}
            for point in points
        ]
        return Population.new(X=genes)

    def points(self, individuals: Any) -> Floats:
        points = np.ones((len(individuals), len(self.lower)))
        for point, genes in zip(points, individuals, strict=True):
            point[self.numbers] = [genes["number", i] for i in self.numbers]
            point[self.bits] *= [genes["bit", i] for i in self.bits]
        return points
