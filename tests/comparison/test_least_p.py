"""Tests that can't find anything say so."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from springopt.comparison.across_scenes import rank
from springopt.comparison.least_p import too_few
from springopt.comparison.record import Record
from springopt.comparison.scene_comparison import compare_on_scene
from springopt.comparison.within_scene import Sample, compare_pairs

MakeRecord = Callable[..., Record]


def notes(record: MakeRecord, folder: Path, runs: int) -> list[str]:
    """Of two random methods with as many runs each."""
    records = [
        record([(1, 1.0 + 0.01 * seed + (name == "a"))], method=name, seed=seed)
        for name in "ab"
        for seed in range(runs)
    ]
    return too_few([compare_on_scene(records, [folder])], None)


def test_three_runs_against_three_never_reach_5_percent_and_four_do(record: MakeRecord, tmp_path: Path) -> None:
    assert "too few runs" in notes(record, tmp_path, 3)[0]  # 2 of the 20 orders of six runs are the clearest
    assert not notes(record, tmp_path, 4)  # 2 of 70


def test_ties_make_three_runs_no_surer() -> None:
    (pair,) = compare_pairs([Sample("a", np.zeros(3), False), Sample("b", np.ones(3), False)])
    assert (pair.p, pair.ends_lower) == (0.1, None)


def test_five_scenes_never_tell_two_methods_apart_and_six_do() -> None:
    few, enough = (rank(["a", "b"], [str(i) for i in range(n)], np.array([[0.1, 0.2]] * n)) for n in (5, 6))
    assert "5 scenes are too few" in too_few([], few)[0]
    assert not too_few([], enough)
    assert few.pairs[0].p_holm > 0.05 > enough.pairs[0].p_holm
