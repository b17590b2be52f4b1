"""The comparison of optimizers that a referee would accept, from run files."""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from springopt.comparison.across_scenes import Ranking, rank
from springopt.comparison.complete_block import Block, complete_block
from springopt.comparison.failure import Failure
from springopt.comparison.least_p import too_few
from springopt.comparison.method_summary import MethodSummary, summarize
from springopt.comparison.profiles import Curves, performance_profile, solved_over_budget
from springopt.comparison.record import UNITS, Record
from springopt.comparison.results import LeftOut, Progress, Refusal, Results, read_results
from springopt.comparison.scene_comparison import SceneComparison, compare_on_scene
from springopt.comparison.targets import clipped
from springopt.comparison.terms import grouped
from springopt.run import plain


@dataclass(frozen=True)
class Comparison:
    """What runs of several optimizers say of them, by scene and over scenes."""

    target: int  #: the summaries' target lies at 10 to the minus this of the way
    methods: list[MethodSummary]
    scenes: list[SceneComparison]
    refusals: list[Refusal]
    failures: list[Failure]  #: runs that failed
    left_out: list[LeftOut]
    block: Block  #: what the ranking is taken from
    ranking: Ranking | None  #: None where no two methods have two scenes in common
    solved_over_budget: list[Curves]  #: one for each unit
    performance_profiles: list[Curves]  #: likewise
    notes: list[str]  #: sentences that a reader must know

    def to_json(self) -> str:
        """All of it as one JSON document; numbers that are not finite are null."""
        return json.dumps(plain(self), allow_nan=False)


def compare(
    paths: Iterable[str | Path],
    *,
    optimizers: Sequence[str] = (),
    scenes: Sequence[str] = (),
    target: int = 2,
    progress: Progress | None = None,
) -> Comparison:
    """Compares the runs in folders of results, or of single files.

    Args:
        paths: see `read_results`.
        optimizers, scenes: those to compare, see `read_results`; by default all.
        target: of the summaries, one of `TARGETS`.
        progress: called for each run that was read, with how many were and how many there are.
    """
    places = [Path(path) for path in paths]
    results = read_results(places, optimizers=optimizers, scenes=scenes, progress=progress)
    folders = [Path(), *(path if path.is_dir() else path.parent for path in places)]
    failed = Counter((each.scene, each.method) for each in results.failures)
    compared = [
        compare_on_scene(records, folders, {method: count for (on, method), count in failed.items() if on == scene})
        for (scene,), records in grouped(results.records, "scene")
    ]
    block = _block(results)
    ranking = _ranking(block, compared)
    ways = {each.scene: each.way for each in compared}
    return Comparison(
        target=target,
        methods=summarize(_order(compared, ranking), compared, target, failed),
        scenes=compared,
        refusals=results.refusals,
        failures=results.failures,
        left_out=results.left_out,
        block=block,
        ranking=ranking,
        solved_over_budget=solved_over_budget(_by_scene_and_method(results.records), ways, failed),
        performance_profiles=_profiles(results.methods, compared),
        notes=[
            *(note for each in compared for note in each.way.notes),
            *results.notes,
            *_unequal_counts(compared),
            *too_few(compared, ranking),
        ],
    )


def _unequal_counts(compared: Sequence[SceneComparison]) -> list[str]:
    """A sentence where some methods have fewer runs than others."""
    counts = {each.runs for scene in compared for each in scene.methods}
    if len(counts) == 1:
        return []
    return [f"an optimizer has {min(counts)} to {max(counts)} runs on a scene: where there are few, less is sure."]


def _order(compared: Sequence[SceneComparison], ranking: Ranking | None) -> list[str]:
    """The ranked methods first, the best before the others; then as they come on the scenes."""
    ranked = list(ranking.mean_ranks) if ranking else []
    return list(dict.fromkeys([*ranked, *(each.method for scene in compared for each in scene.methods)]))


def _by_scene_and_method(records: Sequence[Record]) -> dict[tuple[str, str], list[Record]]:
    return {(scene, method): runs for (scene, method), runs in grouped(records, "scene", "method")}


def _block(results: Results) -> Block:
    served: dict[str, set[str]] = {method: set() for method in results.methods}
    for record in results.records:
        served[record.method].add(record.scene)
    return complete_block(served, {(each.method, each.scene): each.word for each in results.refusals})


def _ranking(block: Block, compared: Sequence[SceneComparison]) -> Ranking | None:
    if len(block.methods) < 2 or len(block.scenes) < 2:
        return None
    medians = {(scene.scene, each.method): each.gap.median for scene in compared for each in scene.methods}
    gaps = np.array([[medians[scene, method] for method in block.methods] for scene in block.scenes])
    return rank(block.methods, block.scenes, clipped(gaps))


def _profiles(methods: Sequence[str], compared: Sequence[SceneComparison]) -> list[Curves]:
    """Performance profiles over all scenes and targets."""
    return [performance_profile(unit, _expected(unit, methods, compared), methods) for unit in UNITS]


def _expected(unit: str, methods: Sequence[str], compared: Sequence[SceneComparison]) -> np.ndarray:
    """Expected running times, a row for each scene and target, inf where there are none."""
    rows = []
    for scene in compared:
        times = {
            each.method: [target.running_times[unit].value for target in each.targets.values()]
            for each in scene.methods
        }
        unsolved = [math.inf] * len(next(iter(times.values())))
        rows += list(zip(*(times.get(method, unsolved) for method in methods), strict=True))
    return np.array(rows)
