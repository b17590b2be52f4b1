"""How much is solved within what: distributions over budgets, and performance profiles.

What is solved are problems: a scene and one of its targets. Scenes that a method can't serve count as not solved, so
that all curves are over the same problems.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from springopt.analysis.way import Way
from springopt.checks import Floats
from springopt.comparison.record import UNITS, Record
from springopt.comparison.targets import TARGETS

POINTS_A_DECADE = 20


@dataclass(frozen=True)
class Curves:
    """One curve for each method: the share of problems that are solved up to each of some places."""

    unit: str
    places: list[float]  #: budgets, or factors of the best method's running time; the same for all methods
    shares: dict[str, list[float]]  #: by method


def solved_over_budget(
    records: Mapping[tuple[str, str], Sequence[Record]],
    ways: Mapping[str, Way],
    failed: Mapping[tuple[str, str], int] | None = None,
) -> list[Curves]:
    """Empirical distributions of running times: the share of (scene, target, run) reached within each budget.

    As COCO draws them (Hansen, Auger, Brockhoff, Tusar and Tusar, *COCO: performance assessment*, arXiv 1605.03560,
    2016), of single runs and not of simulated restarts: a curve ends where the runs do.

    Args:
        records: (scene, method) -> its runs.
        ways: scene -> its way; all of them count.
        failed: (scene, method) -> how many runs failed, which reached nothing; by default none.
    """
    return [_over_budget(unit, records, ways, failed or {}) for unit in UNITS]


def _over_budget(
    unit: str,
    records: Mapping[tuple[str, str], Sequence[Record]],
    ways: Mapping[str, Way],
    failed: Mapping[tuple[str, str], int],
) -> Curves:
    methods = sorted({method for _, method in records})
    times = {
        (scene, method): np.array(
            [record.time_to(ways[scene].target(exponent), unit) for record in runs for exponent in TARGETS]
            + [np.inf] * (len(TARGETS) * failed.get((scene, method), 0))
        )
        for (scene, method), runs in records.items()
    }
    places = _decades(np.concatenate(list(times.values())))
    shares = {
        method: np.mean([_share_within(times.get((scene, method)), places) for scene in sorted(ways)], axis=0).tolist()
        for method in methods
    }
    return Curves(unit, places.tolist(), shares)


def _share_within(times: Floats | None, places: Floats) -> Floats:
    """The share of times up to each place; without runs, or without problems, nothing is solved."""
    if times is None or not len(times):
        return np.zeros(len(places))
    return np.searchsorted(np.sort(times), places, side="right") / len(times)


def performance_profile(unit: str, times: Floats, methods: Sequence[str]) -> Curves:
    """The share of problems that a method solves within a factor of the best method's expected running time.

    Dolan and More (*Benchmarking optimization software with performance profiles*, Math. Program. 91, 2002). Problems
    that no method solves are in no curve.

    Args:
        times: expected running times, inf where a problem is not solved, shape (problems, methods).
    """
    solved = np.isfinite(times).any(axis=1)
    times = times[solved]
    best = times.min(axis=1, initial=np.inf)
    ratios = times / best[:, None]
    places = _decades(ratios.ravel())
    shares = {method: _share_within(ratios[:, i], places).tolist() for i, method in enumerate(methods)}
    return Curves(unit, places.tolist(), shares)


def _decades(times: Floats) -> Floats:
    """Places from the least to the greatest time, evenly over the logarithm, the two ends among them."""
    finite = times[np.isfinite(times) & (times > 0)]
    if not finite.size:
        return np.array([1.0])
    low, high = finite.min(), finite.max()
    count = 2 + int(POINTS_A_DECADE * np.log10(high / low))
    places = np.geomspace(low, high, count)
    places[0], places[-1] = low, high  # to the bit, so that nothing falls out at the ends
    return places
