"""The small problems on which an optimizer is checked."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from typing import Any, Literal

import numpy as np

from springopt.budget import Budget
from springopt.problem import Problem
from springopt.testing.bowl import Bowl, Box
from springopt.testing.small_grid import binary_grid, real_grid


@dataclass(frozen=True, eq=False)
class Task:
    """An objective over the box of an encoding, of which any number of problems can be made."""

    title: str  #: as it stands in a sentence
    objective: Any
    encoding: Any

    @property
    def size(self) -> int:
        return int(self.encoding.size)

    @property
    def supplies(self) -> frozenset[str]:
        """What an optimizer may need and gets here."""
        return Problem(self.objective, self.encoding, Budget(evaluations=1)).supplies

    def with_threads(self, count: int) -> Task:
        """The same task, solved by so many threads; without physics there is nothing to share."""
        if "objective" not in self.supplies:
            return self
        return replace(self, objective=replace(self.objective, model=replace(self.objective.model, threads=count)))

    @property
    def equilibria_sought(self) -> int:
        """By whatever way, since the task was made; 0 without physics."""
        return sum(self.objective.model.sought) if "objective" in self.supplies else 0


@cache
def all_tasks() -> tuple[Task, ...]:
    """With and without physics, in numbers and in bits, and in one of them alone."""
    return (
        _bowl("real", 6),
        _bowl("real", 1),
        _bowl("binary", 20),
        _bowl("binary", 1),
        Task("a grid of 20 springs", *real_grid()),
        Task("a grid of 20 springs that are there or not", *binary_grid()),
    )


def _bowl(kind: Literal["real", "binary"], size: int) -> Task:
    """The best point is a corner's neighbour: of numbers, some are best at an end of their interval."""
    upper, unit = (10.0, "number") if kind == "real" else (1.0, "bit")
    center = np.linspace(-2.0, 12.0, size) if kind == "real" else np.arange(0.0, size) % 2
    title = f"a bowl of {size} {unit}{'s' if size > 1 else ''}"
    return Task(title, Bowl(center), Box(np.zeros(size), np.full(size, upper), kind))
