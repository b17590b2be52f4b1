"""Expected running time to a target, and how sure it is.

The definition is COCO's: all that the runs spent before the target, the unsuccessful ones until they ended, over the
number of successes; the expected cost of restarting until a success (Auger and Hansen, *Performance evaluation of an
advanced local search evolutionary algorithm*, CEC 2005; Hansen, Auger, Ros, Mersmann, Tusar and Brockhoff, *COCO: a
platform for comparing continuous optimizers in a black-box setting*, Optim. Methods Softw. 36, 2021).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.stats import binomtest

from springopt.checks import Booleans, Floats, Integers

RESAMPLES = 1000
CONFIDENCE = 0.95


@dataclass(frozen=True)
class Estimate:
    """A number and its 95 % interval."""

    value: float
    low: float
    high: float


def expected_running_time(spent: Floats, solved: Booleans) -> Floats:
    """Sum of what the runs spent over the number of those that solved it; inf where none did.

    Args:
        spent: until the target, or in the whole run where it was not reached, shape (..., runs).
        solved: whether it was reached, shape (..., runs).
    """
    successes = np.count_nonzero(solved, axis=-1)
    return np.where(successes > 0, spent.sum(axis=-1) / np.maximum(successes, 1), np.inf)


def running_time(spent: Floats, solved: Booleans) -> Estimate:
    """Expected running time with its percentile bootstrap interval over the runs, (runs,) each.

    Where some of the resampled sets have no success, the upper end may be inf: the runs can't tell how long it takes.
    """
    drawn = _resamples(len(spent))
    resampled = expected_running_time(spent[drawn], solved[drawn])
    low, high = np.quantile(resampled, [(1 - CONFIDENCE) / 2, (1 + CONFIDENCE) / 2], method="inverted_cdf")
    return Estimate(float(expected_running_time(spent, solved)), float(low), float(high))


@cache
def success_rate(successes: int, runs: int) -> Estimate:
    """Share of successes with its Wilson interval, which also says something where all or none succeed."""
    interval = binomtest(successes, runs).proportion_ci(CONFIDENCE, method="wilson")
    return Estimate(successes / runs, float(interval.low), float(interval.high))


@cache
def _resamples(runs: int) -> Integers:
    """Runs drawn with replacement, the same for every method with as many, shape (resamples, runs)."""
    return np.random.default_rng(0).integers(runs, size=(RESAMPLES, runs))
