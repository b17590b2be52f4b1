"""One scene: what each method reached there, how fast, and which differ."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from springopt.analysis.way import Way
from springopt.checks import Floats
from springopt.comparison.course import Course, course_of
from springopt.comparison.record import UNITS, Record
from springopt.comparison.running_time import Estimate, running_time, success_rate
from springopt.comparison.targets import TARGETS, clipped, way_of
from springopt.comparison.terms import grouped
from springopt.comparison.within_scene import Pair, Sample, compare_pairs


@dataclass(frozen=True)
class Spread:
    """Median and quartiles over the runs, with the extremes."""

    median: float
    lower_quartile: float
    upper_quartile: float
    lowest: float
    highest: float


@dataclass(frozen=True)
class Target:
    """How often and how fast a target was reached."""

    successes: int
    rate: Estimate
    running_times: dict[str, Estimate]  #: expected, by unit


@dataclass(frozen=True)
class Cost:
    """What the runs took, medians."""

    evaluations: float
    solves: float
    processor_seconds: float
    solving_seconds: float  #: of these, within forward solves and derivatives
    overhead_seconds: float  #: the others: the optimizer's own, and the bookkeeping of the run


@dataclass(frozen=True)
class MethodOnScene:
    """A method's runs on a scene."""

    method: str
    runs: int  #: that ended
    failed: int  #: others, unsuccessful whatever the target
    deterministic: bool  #: all runs, whatever their seeds, took the same course to the bit, see `Record.is_like`
    value: Spread  #: final objective
    gap: Spread  #: share of the way from the start to the floor that was left
    targets: dict[int, Target]  #: by exponent
    train_error: Spread  #: mean distance over the smallest rest length, over the load cases
    test_error: Spread | None  #: the same of held-out load cases; None where there are none
    cost: Cost
    stopped: dict[str, int]  #: by what, how many runs
    course: Course


@dataclass(frozen=True)
class SceneComparison:
    """All methods on one scene."""

    scene: str
    minimize: str
    way: Way
    methods: list[MethodOnScene]  #: by the median gap, the lowest first
    pairs: list[Pair]


def compare_on_scene(
    records: Sequence[Record], folders: Sequence[Path], failed: Mapping[str, int] | None = None
) -> SceneComparison:
    """Summaries of the methods that have these runs, all on one scene, and tests of each pair.

    Args:
        failed: method -> how many runs failed; by default none.
    """
    way = way_of(records, folders)
    runs = {method: group for (method,), group in grouped(records, "method")}
    methods = sorted(
        (summary(group, way, (failed or {}).get(method, 0)) for method, group in runs.items()),
        key=lambda each: (each.gap.median, each.method),
    )
    samples = [sample_of(runs[each.method], way) for each in methods]
    return SceneComparison(records[0].scene, records[0].minimize, way, methods, compare_pairs(samples))


def are_alike(records: Sequence[Record]) -> bool:
    """Whether several runs of a method all took the same course."""
    longest = max(records, key=lambda record: record.total["evaluations"])
    return len(records) > 1 and all(record.is_like(longest) for record in records)


def sample_of(records: Sequence[Record], way: Way) -> Sample:
    """The final gaps of a method, as they are tested."""
    deterministic = are_alike(records)
    gaps = clipped(np.array([way.gap(record.value) for record in records]))
    return Sample(records[0].method, np.array([np.median(gaps)]) if deterministic else gaps, deterministic)


def summary(records: Sequence[Record], way: Way, failed: int = 0) -> MethodOnScene:
    """What a method's runs on one scene come to, of which so many more failed."""
    values, alike = np.array([record.value for record in records]), are_alike(records)
    tests = [record.test_error for record in records if record.test_error is not None]
    return MethodOnScene(
        method=records[0].method,
        runs=len(records),
        failed=failed,
        deterministic=alike,
        value=_spread(values),
        gap=_spread(np.array([way.gap(value) for value in values])),
        targets={exponent: _target(records, way, exponent, failed, alike) for exponent in TARGETS},
        train_error=_spread(np.array([record.train_error for record in records])),
        test_error=_spread(np.array(tests)) if tests else None,
        cost=_cost(records),
        stopped=dict(Counter(record.why_stopped for record in records)),
        course=course_of(records, way),
    )


def _target(records: Sequence[Record], way: Way, exponent: int, failed: int, alike: bool) -> Target:
    times = {unit: np.array([record.time_to(way.target(exponent), unit) for record in records]) for unit in UNITS}
    solved = np.isfinite(times["evaluations"])
    totals = {unit: np.array([record.total[unit] for record in records]) for unit in UNITS}
    expected = {unit: running_time(np.where(solved, times[unit], totals[unit]), solved) for unit in UNITS}
    successes = int(solved.sum())
    rate = success_rate(successes, len(records) + failed)
    if alike and not failed and successes in (0, len(records)):
        rate = Estimate(rate.value, rate.value, rate.value)  # one answer, and nothing to be unsure of
    return Target(successes, rate, expected)


def _cost(records: Sequence[Record]) -> Cost:
    medians = {unit: float(np.median([record.total[unit] for record in records])) for unit in UNITS}
    solving = np.array([record.solving_seconds for record in records])
    overhead = np.array([record.total["processor_seconds"] for record in records]) - solving
    return Cost(**medians, solving_seconds=float(np.median(solving)), overhead_seconds=float(np.median(overhead)))


def _spread(values: Floats) -> Spread:
    """Where one value is inf, quartiles are values that occurred."""
    ends = [0.5, 0.25, 0.75, 0.0, 1.0]
    finite = np.isfinite(values).all()
    return Spread(*(np.quantile(values, ends) if finite else np.quantile(values, ends, method="inverted_cdf")).tolist())
