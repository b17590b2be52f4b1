"""The best value of a run, generation by generation."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from springopt.checks import Floats, Integers
from springopt.run import Improvement


def best_values(histories: Sequence[Sequence[Improvement]], population: int, generations: int) -> Floats:
    """Best value when each generation from the first on was evaluated, shape (runs, generations)."""
    spent = population * np.arange(1, generations + 1)
    return np.stack([_best(history, spent) for history in histories])


def _best(history: Sequence[Improvement], spent: Integers) -> Floats:
    counts = np.array([improvement.evaluations for improvement in history])
    values = np.array([improvement.value for improvement in history])
    last = np.searchsorted(counts, spent, side="right") - 1
    return np.where(last >= 0, values[np.maximum(last, 0)], values[0])
