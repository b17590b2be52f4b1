"""How large a difference is, beside how sure."""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq
from scipy.stats import norm, rankdata

from springopt.checks import Floats
from springopt.comparison.running_time import CONFIDENCE, Estimate


def probability_of_lower(first: Floats, second: Floats) -> Estimate:
    """Probability that a run of the first ends lower than one of the second, ties half: 1/2 without a difference.

    The measure A of Vargha and Delaney (*A critique and improvement of the CL common language effect size statistics*,
    J. Educ. Behav. Stat. 25, 2000), for lower values; with the interval by Newcombe's fifth method (*Confidence
    intervals for an effect size measure based on the Mann-Whitney statistic, part 2*, Stat. Med. 25, 2006), which is
    none of zero width where one sample lies wholly below the other.

    Args:
        first, second: values, shape (m,) and (n,).
    """
    lower = np.count_nonzero(first[:, None] < second) + 0.5 * np.count_nonzero(first[:, None] == second)
    share = float(lower / (len(first) * len(second)))
    return Estimate(share, _end(share, len(first), len(second), 0.0), _end(share, len(first), len(second), 1.0))


def _end(share: float, m: int, n: int, extreme: float) -> float:
    """The end of the interval towards an extreme: the true probability that the share just does not speak against."""
    if share == extreme:
        return extreme
    z = norm.ppf((1 + CONFIDENCE) / 2)
    half = (m + n) / 2 - 1

    def excess(true: float) -> float:
        variance = true * (1 - true) * (1 + half * ((1 - true) / (2 - true) + true / (1 + true))) / (m * n)
        return (true - share) ** 2 - z**2 * variance

    beside = share + 1e-9 * (extreme - share)  # at a share of 0 or 1 itself the variance is none
    return float(brentq(excess, beside, extreme))


def rank_biserial(differences: Floats) -> float:
    """Matched-pairs rank-biserial correlation: the share of rank sums that speaks for, less that against (Kerby 2014).

    -1 where all differences are negative, 1 where all are positive. Differences of zero speak for both sides alike, as
    in Wilcoxon's test.

    Args:
        differences: of pairs, shape (n,).
    """
    ranks = rankdata(np.abs(differences))
    return float(np.sum(np.sign(differences) * ranks) / ranks.sum())
