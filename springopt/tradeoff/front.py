"""What is worth its time: the Pareto front of error and time, and what one digit more costs along it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from springopt.checks import Floats
from springopt.tradeoff.interval import CONFIDENCE, Interval
from springopt.tradeoff.point import Point

RESAMPLES = 1000
OUT_OF_REACH = 1_000
LEAST_DIGITS = 0.3  # a factor of two: less is no digit to speak of


def pareto_front(points: Sequence[Point]) -> list[Point]:
    """Those that no other one beats in error and in processor time, the fastest first; of good ones alone."""
    good = [point for point in points if point.is_good and point.error is not None]
    good.sort(key=lambda point: (point.processor_seconds.value, _error(point)))
    front: list[Point] = []
    for point in good:
        if not front or _error(point) < _error(front[-1]):
            front.append(point)
    return front


@dataclass(frozen=True)
class Price:
    """What one digit more costs: the factor of the time for a tenth of the error."""

    factor: Interval
    digits: float  #: between the least and the most accurate of the points that it is found from

    @property
    def said(self) -> str:
        """As in "one digit more costs 3.1 times (2.6 to 3.8)"; what nobody would pay is out of reach."""
        if self.factor.value > OUT_OF_REACH:
            return f"one digit more is out of reach: it would cost more than {OUT_OF_REACH:,} times"
        value, low, high = (f"{number:.3g}" for number in (self.factor.value, self.factor.low, self.factor.high))
        # Of single repeats all resamples are the same.
        interval = "too few repeats for an interval" if self.factor.low == self.factor.high else f"{low} to {high}"
        return f"one digit more costs {value} times ({interval})"


def price_of_a_digit(points: Sequence[Point]) -> Price | None:
    """From the points of a front, or of a series; None where these are too few, or span no digit for sure.

    The slope of log time over log error is the median of those of all pairs (Theil 1950, Sen 1968) a factor of
    two apart in error, its interval that of resampled repeats.
    """
    front = [point for point in pareto_front(points) if _error(point) > 0.0]
    if len(front) < 2:
        return None
    digits = float(np.log10(_error(front[0])) - np.log10(_error(front[-1])))
    if digits < LEAST_DIGITS:
        return None
    rng = np.random.default_rng(0)
    times = np.column_stack([_resampled_medians(point.processor, rng) for point in front])
    errors = np.column_stack([_resampled_medians(point.errors, rng) for point in front])
    slopes = _slopes(np.log10(times), -np.log10(np.maximum(errors, np.finfo(float).tiny)))
    if np.isnan(slopes).mean() > 1 - CONFIDENCE:
        return None
    found = 10.0**slopes
    low, high = np.nanquantile(found[1:], [(1 - CONFIDENCE) / 2, (1 + CONFIDENCE) / 2])
    return Price(Interval(float(found[0]), float(low), float(high)), digits)


def _error(point: Point) -> float:
    assert point.error is not None  # of good ones alone
    return point.error.value


def _resampled_medians(numbers: Floats, rng: np.random.Generator) -> Floats:
    """The median of the numbers, and of so many that are drawn from them, shape (1 + RESAMPLES,)."""
    drawn = numbers[rng.integers(len(numbers), size=(RESAMPLES, len(numbers)))]
    return np.concatenate([[np.median(numbers)], np.median(drawn, axis=1)])


def _slopes(rises: Floats, runs: Floats) -> Floats:
    """The median slope of all pairs of columns that are apart, a number a row, (rows,); nan where none are."""
    i, j = np.triu_indices(rises.shape[1], 1)
    steps = runs[:, j] - runs[:, i]
    # Pairs that hardly differ, or that a resample has the other way round, say nothing of a digit.
    is_apart = steps >= LEAST_DIGITS
    slopes = np.where(is_apart, (rises[:, j] - rises[:, i]) / np.where(is_apart, steps, 1.0), np.nan)
    found = np.full(len(slopes), np.nan)
    told = is_apart.any(axis=1)
    found[told] = np.nanmedian(slopes[told], axis=1)
    return found
