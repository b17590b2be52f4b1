"""Whether two methods differ on one scene: tests of final values, run against run.

The runs of two methods have nothing in common but a number, so the test is unpaired: Mann and Whitney's. A method whose
runs are all the same to the bit has given one answer, not fifteen; against it the question is whether the other
method's runs lie on one side of it, which is the sign test. Two such methods differ or they do not: no test.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Literal

import numpy as np
from scipy.stats import binomtest

from springopt.checks import Floats
from springopt.comparison.effect_size import probability_of_lower
from springopt.comparison.holm import holm
from springopt.comparison.rank_sum import mann_whitney
from springopt.comparison.running_time import Estimate, success_rate

TestName = Literal["Mann-Whitney", "sign", "none"]
Verdict = tuple[TestName, float | None, Estimate]  # p, and how probably the first ends lower

ALPHA = 0.05


@dataclass(frozen=True)
class Sample:
    """The final gaps of a method's runs on a scene, clipped; one number of a method whose runs are all the same."""

    method: str
    gaps: Floats
    deterministic: bool


@dataclass(frozen=True)
class Pair:
    """Two methods on one scene."""

    first: str
    second: str
    test: TestName
    p: float | None  #: two-sided; None where both are deterministic
    p_holm: float | None  #: corrected for all pairs of the scene
    lower: Estimate  #: how probably a run of the first ends lower than one of the second, ties half
    ends_lower: str | None  #: the one whose runs end lower, where the corrected test says so, or neither is random


def compare_pairs(samples: Sequence[Sample]) -> list[Pair]:
    """Every pair of methods, in the order given."""
    pairs = list(combinations(samples, 2))
    verdicts = [_compare(first, second) for first, second in pairs]
    corrected = iter(holm(np.array([p for _, p, _ in verdicts if p is not None])).tolist())
    return [
        _pair(first.method, second.method, verdict, None if verdict[1] is None else next(corrected))
        for (first, second), verdict in zip(pairs, verdicts, strict=True)
    ]


def _pair(first: str, second: str, verdict: Verdict, p_holm: float | None) -> Pair:
    test, p, lower = verdict
    differ = (p_holm is None or p_holm < ALPHA) and lower.value != 0.5
    return Pair(first, second, test, p, p_holm, lower, (first if lower.value > 0.5 else second) if differ else None)


def _compare(first: Sample, second: Sample) -> Verdict:
    if first.deterministic and second.deterministic:
        share = 0.5 * (1 + float(np.sign(second.gaps[0] - first.gaps[0])))
        return "none", None, Estimate(share, share, share)
    if second.deterministic:
        return "sign", _sign_test(first.gaps, second.gaps[0]), _below(first.gaps, second.gaps[0])
    if first.deterministic:
        test, p, below = _compare(second, first)
        return test, p, Estimate(1 - below.value, 1 - below.high, 1 - below.low)
    return "Mann-Whitney", mann_whitney(first.gaps, second.gaps), probability_of_lower(first.gaps, second.gaps)


def _sign_test(gaps: Floats, constant: float) -> float:
    """Two-sided p that as many lie above a constant as below; those at it say nothing."""
    above, below = np.count_nonzero(gaps > constant), np.count_nonzero(gaps < constant)
    return float(binomtest(above, above + below).pvalue) if above + below else 1.0


def _below(gaps: Floats, constant: float) -> Estimate:
    """How probably a run ends below a constant, ties half; the interval takes them for either side."""
    below, ties, runs = np.count_nonzero(gaps < constant), np.count_nonzero(gaps == constant), len(gaps)
    low, high = success_rate(below, runs).low, success_rate(below + ties, runs).high
    return Estimate((below + ties / 2) / runs, low, high)
