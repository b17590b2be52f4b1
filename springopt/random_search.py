"""Random search: the baseline that every optimizer must beat."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from springopt.errors import UserError
from springopt.optimizer import Optimizer
from springopt.problem import Problem


@dataclass(frozen=True)
class RandomSearch(Optimizer):
    """Uniform sampling of the box."""

    name: ClassVar[str] = "random-search"
    batch: int = 32  #: candidates per call

    def __post_init__(self) -> None:
        if self.batch < 1:
            raise UserError(f"option batch of random-search is at least 1, not {self.batch}; give more candidates.")

    def minimize(self, problem: Problem, rng: np.random.Generator) -> None:
        while problem.budget_left:
            problem.best_of(problem.sample(rng, self.batch), 1, rivals=[problem.best_value])
