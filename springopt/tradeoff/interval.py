"""A number that was found several times: its median, and how sure that is."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from math import comb

import numpy as np

CONFIDENCE = 0.95


@dataclass(frozen=True)
class Interval:
    """A median and the interval that holds it with 95 %; of fewer than six numbers their range."""

    value: float
    low: float
    high: float

    @classmethod
    def of(cls, numbers: Iterable[float]) -> Interval:
        """By order statistics, which take no distribution for granted (David and Nagaraja 2003, section 7.1)."""
        ordered = np.sort(np.fromiter(numbers, dtype=float))
        below = _left_out(len(ordered))
        return cls(float(np.median(ordered)), float(ordered[below]), float(ordered[-1 - below]))

    @property
    def width(self) -> float:
        """Over the median; 0 where all are 0."""
        return (self.high - self.low) / self.value if self.value else 0.0

    def over(self, divisor: float) -> Interval:
        return Interval(self.value / divisor, self.low / divisor, self.high / divisor)


@cache
def _left_out(count: int) -> int:
    """How many of the ordered numbers may be left out at either end: the median lies beyond with 5 % at most.

    It is below the number after the k least where k of the numbers or fewer are below it.
    """
    tail, left_out = 2.0**-count, 0
    while left_out + 1 < count / 2:
        tail += comb(count, left_out + 1) / 2**count
        if tail > (1 - CONFIDENCE) / 2:
            break
        left_out += 1
    return left_out
