"""Runs that failed are unsuccessful: with them nothing looks better than without."""

from collections.abc import Callable
from pathlib import Path

import pytest

from springopt.comparison.comparison import compare
from springopt.comparison.results import read_results


def fail(place: Path, *seeds: int) -> None:
    place.mkdir(parents=True, exist_ok=True)
    for seed in seeds:
        (place / f"seed{seed}.h5").unlink(missing_ok=True)
        (place / f"seed{seed}.failed.json").write_text('{"sentence": "the optimizer divided by zero."}')


def test_they_count_as_unsuccessful_in_rates_and_curves(folder: Path) -> None:
    fail(folder / "nine" / "wide", 1, 2)
    after = compare([folder])
    wide = next(each for each in after.scenes[0].methods if each.method == "wide")
    (summary,) = [each for each in after.methods if each.method == "wide"]
    assert (wide.runs, wide.failed, summary.failed) == (1, 2, 2)
    assert all(reached.rate.value == reached.successes / 3 for reached in wide.targets.values())
    reached = sum(reached.successes for reached in wide.targets.values())
    for curves in after.solved_over_budget:
        assert curves.shares["wide"][-1] == pytest.approx(reached / (3 * 6))
    assert any("runs failed (2 of wide on nine)" in note for note in after.notes)


def test_where_all_fail_the_scene_counts_and_the_word_says_so(two_scenes: Path) -> None:
    before, _ = compare([two_scenes]), fail(two_scenes / "soft" / "wide", 0)
    after = compare([two_scenes])
    assert [(each.scene, each.method, each.word) for each in after.refusals][-1] == ("soft", "wide", "failed")
    (old,), (new,) = ([each for each in found.methods if each.method == "wide"] for found in (before, after))
    assert (old.scenes, new.scenes, new.failed) == (2, 2, 1)
    assert new.success_rate <= old.success_rate
    assert after.block.scenes_left_out == {"soft": "no runs of wide (failed)"}


def test_a_failure_that_was_made_good_is_none(folder: Path) -> None:
    (folder / "nine" / "wide" / "seed1.failed.json").write_text('{"sentence": "the disk was full."}')
    assert not read_results([folder]).failures


def test_a_failure_of_settings_that_are_kept_apart_counts_against_each(
    folder: Path, add_run: Callable[..., Path]
) -> None:
    add_run("wide", 4, seed=7)
    fail(folder / "nine" / "wide", 9)
    assert [each.method for each in read_results([folder]).failures] == ["wide (batch=4)", "wide (batch=8)"]


@pytest.mark.parametrize("name", ["wide", "narrow"])
def test_only_those_asked_for_are_told(folder: Path, name: str) -> None:
    fail(folder / "nine" / "wide", 9)
    failures = read_results([folder], optimizers=[name]).failures
    assert [each.method for each in failures] == (["wide"] if name == "wide" else [])
