"""A method over all its scenes, in one line."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from springopt.comparison.record import UNITS
from springopt.comparison.scene_comparison import MethodOnScene, SceneComparison


@dataclass(frozen=True)
class MethodSummary:
    """What a method did over the scenes that it has runs on."""

    method: str
    scenes: int  #: that it has runs on, failed ones as well
    runs: int  #: that ended
    failed: int  #: others
    reached: int  #: scenes whose target at least one run reached
    solvable: int  #: of its scenes, those whose target any method reached
    success_rate: float  #: mean over its scenes of the share of runs that reached the target
    #: Median over the solvable scenes of its expected running time over the best method's, by unit; inf where it
    #: reached at most half of them, None without such scenes.
    times_the_best: dict[str, float | None]
    better: int  #: pairs of a scene and another method where its final values are lower, at 5 % after Holm's correction
    even: int
    worse: int
    #: Medians of the runs' medians over the scenes that have test load cases; None without such scenes.
    train_error: float | None
    test_error: float | None
    overhead_share: float  #: median over scenes of what is not forward solve, of the processor seconds
    overhead_per_evaluation: float  #: the same in processor seconds for each evaluation


def summarize(
    methods: Sequence[str],
    scenes: Sequence[SceneComparison],
    target: int,
    failed: Mapping[tuple[str, str], int] | None = None,
) -> list[MethodSummary]:
    """One summary for each method that has a run, for a target of 10 to the minus this.

    Args:
        failed: (scene, method) -> how many runs failed; by default none.
    """
    summaries = []
    for method in methods:
        its_failed = {scene: count for (scene, other), count in (failed or {}).items() if other == method}
        summaries.append(_summary(method, scenes, target, its_failed))
    return [summary for summary in summaries if summary]


def _summary(
    method: str, scenes: Sequence[SceneComparison], target: int, failed: Mapping[str, int]
) -> MethodSummary | None:
    its = {scene.scene: each for scene in scenes for each in scene.methods if each.method == method}
    if not its:
        return None
    solvable = [
        scene
        for scene in scenes
        if (scene.scene in its or scene.scene in failed)
        and any(each.targets[target].successes for each in scene.methods)
    ]
    lost = set(failed) - set(its)  # scenes where no run is left: nothing was reached there
    rates = [each.targets[target].rate.value for each in its.values()] + [0.0] * len(lost)
    better, even, worse = _outcomes(method, scenes)
    errors = [(each.train_error.median, each.test_error.median) for each in its.values() if each.test_error]
    each_per_evaluation = [each.cost.overhead_seconds / each.cost.evaluations for each in its.values()]
    return MethodSummary(
        method=method,
        scenes=len(its) + len(lost),
        runs=sum(each.runs for each in its.values()),
        failed=sum(failed.values()),
        reached=sum(each.targets[target].successes > 0 for each in its.values()),
        solvable=len(solvable),
        success_rate=float(np.mean(rates)),
        times_the_best={unit: _times_the_best(its, solvable, target, unit) for unit in UNITS},
        better=better,
        even=even,
        worse=worse,
        train_error=_median([train for train, _ in errors]),
        test_error=_median([test for _, test in errors]),
        overhead_share=float(np.median([_overhead_share(each) for each in its.values()])),
        overhead_per_evaluation=float(np.median(each_per_evaluation)),
    )


def _times_the_best(
    its: Mapping[str, MethodOnScene], solvable: Sequence[SceneComparison], target: int, unit: str
) -> float | None:
    ratios = []
    for scene in solvable:
        best = min(each.targets[target].running_times[unit].value for each in scene.methods)
        own = its.get(scene.scene)
        ratios.append(own.targets[target].running_times[unit].value / best if own else math.inf)
    return _median(ratios)


def _outcomes(method: str, scenes: Sequence[SceneComparison]) -> tuple[int, int, int]:
    """How many tests within scenes speak for a method, for neither, and against it."""
    better = even = worse = 0
    for pair in (pair for scene in scenes for pair in scene.pairs if method in (pair.first, pair.second)):
        better += pair.ends_lower == method
        even += pair.ends_lower is None
        worse += pair.ends_lower not in (method, None)
    return better, even, worse


def _overhead_share(each: MethodOnScene) -> float:
    return each.cost.overhead_seconds / each.cost.processor_seconds


def _median(numbers: Sequence[float | None]) -> float | None:
    known = [number for number in numbers if number is not None]
    return float(np.median(known)) if known else None
