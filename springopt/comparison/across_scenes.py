"""Whether methods differ over scenes: ranks, tests of scene medians, and a critical difference.

As Demsar recommends (*Statistical comparisons of classifiers over multiple data sets*, J. Mach. Learn. Res. 7, 2006),
with the pairs tested by Wilcoxon's signed ranks rather than by mean ranks, which depend on the other methods of the
comparison (Benavoli, Corani and Mangili, *Should we really use post-hoc tests based on mean-ranks?*, J. Mach. Learn.
Res. 17, 2016).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.stats import f as f_distribution
from scipy.stats import friedmanchisquare, rankdata, studentized_range

from springopt.checks import Floats
from springopt.comparison.effect_size import rank_biserial
from springopt.comparison.holm import holm

ALPHA = 0.05
ROUNDING = 1e-9  # of the greatest chi-square; ranks that differ at all leave far more


@dataclass(frozen=True)
class Friedman:
    """Whether any of several methods differs."""

    chi_square: float  #: corrected for ties
    p: float
    f: float | None  #: Iman and Davenport's statistic, which is less conservative; None where all scenes rank alike
    p_f: float | None
    kendall_w: float  #: effect size: 0 where the scenes rank the methods at random, 1 where all rank them alike


@dataclass(frozen=True)
class ScenePair:
    """Two methods over the scenes."""

    first: str
    second: str
    p: float  #: Wilcoxon's, two-sided
    p_holm: float  #: corrected for all pairs
    rank_biserial: float  #: effect size: 1 where the first is lower on every scene, -1 where the second is


@dataclass(frozen=True)
class Ranking:
    """Methods that have runs on all of the scenes."""

    scenes: list[str]
    mean_ranks: dict[str, float]  #: 1 is best; the best first
    critical_difference: float  #: Nemenyi's: mean ranks closer than this do not differ, at 5 %
    friedman: Friedman | None  #: None for two methods, where Wilcoxon's test says all
    pairs: list[ScenePair]


def rank(methods: Sequence[str], scenes: Sequence[str], gaps: Floats) -> Ranking:
    """Ranks methods by their median gaps, clipped, shape (scenes, methods)."""
    ranks = rankdata(gaps, axis=1).mean(axis=0)
    order = np.argsort(ranks, kind="stable")
    named = [methods[i] for i in order]
    return Ranking(
        scenes=list(scenes),
        mean_ranks=dict(zip(named, ranks[order].tolist(), strict=True)),
        critical_difference=critical_difference(len(methods), len(scenes)),
        friedman=friedman(gaps) if len(methods) > 2 else None,
        pairs=_pairs(named, gaps[:, order]),
    )


def critical_difference(methods: int, scenes: int, *, alpha: float = ALPHA) -> float:
    """Nemenyi's, from the studentized range (Demsar 2006, section 3.2.2)."""
    quantile = studentized_range.ppf(1 - alpha, methods, np.inf) / math.sqrt(2)
    return float(quantile * math.sqrt(methods * (methods + 1) / (6 * scenes)))


def friedman(gaps: Floats) -> Friedman:
    """Friedman's test of three methods or more, shape (scenes, methods)."""
    scenes, methods = gaps.shape
    if (np.ptp(gaps, axis=1) == 0).all():
        return Friedman(0.0, 1.0, 0.0, 1.0, 0.0)
    chi_square, p = (float(number) for number in friedmanchisquare(*gaps.T))
    f, p_f = iman_davenport(chi_square, scenes, methods)
    return Friedman(chi_square, p, f, p_f, chi_square / (scenes * (methods - 1)))


def iman_davenport(chi_square: float, scenes: int, methods: int) -> tuple[float, float] | tuple[None, None]:
    """F statistic and its p (Demsar 2006, section 3.2.2).

    None where all scenes rank alike: F is infinite then, and its p of 0 is what no finite number of scenes can show.
    """
    most = scenes * (methods - 1)
    rest = most - chi_square
    if rest <= ROUNDING * most:
        return None, None
    f = (scenes - 1) * chi_square / rest
    return f, float(f_distribution.sf(f, methods - 1, (methods - 1) * (scenes - 1)))


def signed_ranks(differences: Floats) -> float:
    """Wilcoxon's two-sided p of differences on the same scenes, shape (scenes,); exact, with ties as well.

    Those of zero are ranked too, and their ranks shared out between both sides, as in Demsar's example. The
    distribution is summed up rank by rank, because `scipy.stats.wilcoxon` is exact without ties alone, or tries all
    signs in turn.
    """
    ranks = np.rint(2 * rankdata(np.abs(differences))).astype(int)[differences != 0]  # doubled: ties have half ranks
    share = np.ones(1)  # of the signs, by the sum of the ranks that are positive
    for each in ranks:
        share = (np.pad(share, (0, each)) + np.pad(share, (each, 0))) / 2
    balance = np.abs(2 * np.arange(len(share)) - ranks.sum())
    found = abs(2 * ranks[differences[differences != 0] > 0].sum() - ranks.sum())
    return float(min(share[balance >= found].sum(), 1.0))


def _pairs(methods: Sequence[str], gaps: Floats) -> list[ScenePair]:
    """Differences are of logarithms, so that a factor of ten in the gap counts alike near the floor and far from it."""
    logs = np.log10(gaps)
    indices = list(combinations(range(len(methods)), 2))
    differences = [logs[:, j] - logs[:, i] for i, j in indices]
    p_values = np.array([signed_ranks(each) for each in differences])
    return [
        ScenePair(methods[i], methods[j], p, p_holm, rank_biserial(each))
        for (i, j), p, p_holm, each in zip(
            indices, p_values.tolist(), holm(p_values).tolist(), differences, strict=True
        )
    ]
