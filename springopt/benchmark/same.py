"""Whether two runs came to the same result, to the last bit."""

from __future__ import annotations

from typing import Any

import numpy as np

from springopt.store import RunFile


def same_result(first: RunFile, second: RunFile) -> bool:
    """Whether orders, histories, points and all other facts but times and paths are equal, bit by bit."""
    return (
        first.order.to_json() == second.order.to_json()
        and _same(first.run.timeless(), second.run.timeless())
        and _same(first.positions, second.positions)
    )


def _same(first: Any, second: Any) -> bool:
    if isinstance(first, np.ndarray):
        return first.dtype == second.dtype and first.shape == second.shape and first.tobytes() == second.tobytes()
    if isinstance(first, dict):
        return first.keys() == second.keys() and all(_same(first[key], second[key]) for key in first)
    if isinstance(first, list | tuple):
        return len(first) == len(second) and all(map(_same, first, second))
    return first == second
