"""Whether the tests can find anything: the least p that so few runs, or scenes, can give."""

from __future__ import annotations

from collections.abc import Sequence
from math import comb

from springopt.comparison.across_scenes import Ranking
from springopt.comparison.scene_comparison import SceneComparison
from springopt.comparison.within_scene import ALPHA


def too_few(scenes: Sequence[SceneComparison], ranking: Ranking | None) -> list[str]:
    """A sentence for each kind of test that cannot reach 5 % after Holm's correction, whatever the runs had found."""
    notes = []
    if scenes and not any(_can_differ(scene) for scene in scenes):
        notes.append(
            "there are too few runs for any test within a scene to reach 5 % after Holm's correction; "
            "compare fewer optimizers, or run more seeds."
        )
    if ranking and 2 * 0.5 ** len(ranking.scenes) * len(ranking.pairs) >= ALPHA:
        notes.append(
            f"{len(ranking.scenes)} scenes are too few for any of {len(ranking.pairs)} pairs to differ over scenes at "
            "5 % after Holm's correction; compare fewer optimizers, or more scenes."
        )
    return notes


def _can_differ(scene: SceneComparison) -> bool:
    """Whether the clearest outcome of some pair would count; pairs of deterministic methods need no test."""
    tests = [pair.test for pair in scene.pairs if pair.test != "none"]
    runs = sorted((each.runs for each in scene.methods if not each.deterministic), reverse=True)
    if not runs or not tests:
        return True
    clearest = [2 * 0.5 ** runs[0]] if "sign" in tests else []
    clearest += [2 / comb(runs[0] + runs[1], runs[0])] if "Mann-Whitney" in tests else []
    return min(clearest) * len(tests) < ALPHA
