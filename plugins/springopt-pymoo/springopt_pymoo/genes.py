"""Points as pymoo's mixed variables."""

from __future__ import annotations

from typing import Any

import numpy as np
from pymoo.core.population import Population
from pymoo.core.variable import Binary, Real

from springopt.checks import Floats
from springopt.problem import Problem
from springopt_pymoo.search import Survivors


class Genes(Survivors):
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
