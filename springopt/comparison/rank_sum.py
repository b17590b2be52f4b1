"""Mann and Whitney's test of two samples, by the sum of ranks; exact for small samples, with ties as well.

`scipy.stats.mannwhitneyu` is exact without ties alone; with them its normal approximation finds in few runs what no
such runs can show.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from scipy.stats import mannwhitneyu, rankdata

from springopt.checks import Floats

EXACT_UP_TO = 60  # values of both samples; above it the approximation is good, and the exact sum slow


def mann_whitney(first: Floats, second: Floats) -> float:
    """Two-sided p of two samples, shape (m,) and (n,): twice the smaller tail, as SciPy has it."""
    both = np.concatenate([first, second])
    if np.ptp(both) == 0:
        return 1.0
    if len(both) > EXACT_UP_TO:
        return float(mannwhitneyu(first, second, method="asymptotic").pvalue)
    ranks = np.rint(2 * rankdata(both)).astype(int)  # doubled: ties have half ranks
    share = _shares(tuple(sorted(ranks.tolist())), len(first))
    found = ranks[: len(first)].sum()
    return float(min(2 * min(share[: found + 1].sum(), share[found:].sum()), 1.0))


@lru_cache(maxsize=256)
def _shares(ranks: tuple[int, ...], size: int) -> Floats:
    """The share of all subsets of a size, by the sum of their ranks, shape (sum of all + 1,).

    One rank after the other joins the subsets without it (Streitberg and Roehmel, *Exact distributions for permutation
    and rank tests*, Statist. Software Newsl. 12, 1986).
    """
    subsets = np.zeros((size + 1, sum(ranks) + 1))  # how many, by size and sum
    subsets[0, 0] = 1
    for rank in ranks:
        subsets[1:, rank:] += subsets[:-1, :-rank]
    return np.asarray(subsets[size] / subsets[size].sum())
