"""Floors on the command line: computed, stored, replaced, and beside every result."""

import json
from pathlib import Path

import pytest

SOLVE = ("solve", "--optimizer", "random-search", "--evaluations", "20")
OUT_OF_REACH = """
extends = "paper-fem-2d-homogeneous"
title = "A scene of one's own"
[encoding]
upper = 3.0
"""


@pytest.fixture
def mine(springopt) -> Path:
    path = Path("mine.toml")
    path.write_text(OUT_OF_REACH)
    return path


def test_a_floor_is_computed_and_stored_beside_the_scene(springopt, mine: Path) -> None:
    code, out, err = springopt("floor", "mine.toml", "--starts", "3")
    assert (code, err) == (0, "")
    assert "mine: floor 0." in out
    assert "(distance), best known\n3 of 3 starts ended there" in out
    assert "Stored in mine.floor.json\n" in out
    floor = json.loads(Path("mine.floor.json").read_text())
    assert (floor["scene"], floor["point"]) == ("mine", [3.0])


def test_a_floor_as_json_is_what_is_stored(springopt, mine: Path) -> None:
    answer = json.loads(springopt("floor", "mine.toml", "--starts", "2", "--json").out)
    assert answer.pop("file") == "mine.floor.json"
    assert answer == json.loads(Path("mine.floor.json").read_text())


def stored(**facts: object) -> None:
    """Facts of the stored floor replaced."""
    path = Path("mine.floor.json")
    path.write_text(json.dumps(json.loads(path.read_text()) | facts))


def test_results_say_how_far_they_are_from_the_floor(springopt, mine: Path) -> None:
    springopt("floor", "mine.toml", "--starts", "2")
    stored(analytic=None, sampled=None)
    value = json.loads(springopt(*SOLVE, "mine.toml", "--out", "a.h5", "--json").out)["objective"]
    floor = json.loads(Path("mine.floor.json").read_text())["value"]
    assert (
        f"{100 * (value / floor - 1):.3g} % above the floor {floor:.6g} (best known)" in springopt("show", "a.h5").out
    )
    stored(analytic=2 * value)
    out = springopt("show", "a.h5").out
    share = (2 * value - value) / (2 * value - floor)
    assert f"{100 * share:.4g} % of the way from the analytic start {2 * value:.6g} to the floor {floor:.6g}" in out
    assert json.loads(springopt("show", "a.h5", "--json").out)["floor"] == {
        "value": floor,
        "proven": False,
        "analytic": 2 * value,
        "sampled": None,
        "fraction": pytest.approx(share),
    }
    stored(analytic=0.9 * value)
    assert f"worse than the analytic start {0.9 * value:.6g}; the floor is {floor:.6g}" in springopt("show", "a.h5").out


def test_where_there_is_no_analytic_start_the_way_is_from_random_samples(springopt) -> None:
    out = springopt(*SOLVE, "paper-topology-3d").out
    assert "% of the way from the median of random samples 3.08365 to the floor 0 (proven)" in out


def test_solve_says_the_same_as_show_and_finds_the_floor_beside_the_scene(springopt, mine: Path) -> None:
    springopt("floor", "mine.toml", "--starts", "2")
    Path("elsewhere").mkdir()
    solved = springopt(*SOLVE, "mine.toml", "--out", "elsewhere/a.h5").out
    assert "the floor" in solved
    assert solved.partition("Run file")[0] == springopt("show", "elsewhere/a.h5").out.partition("Run file")[0]


def test_a_zero_floor_is_said(springopt) -> None:
    out = springopt(*SOLVE, "paper-stiffness-2d").out
    assert "floor" in out
    assert "0 (proven)" in out


def test_a_scene_without_a_floor_has_no_line(springopt, mine: Path) -> None:
    assert "floor" not in springopt(*SOLVE, "mine.toml", "--out", "a.h5").out
    assert json.loads(springopt("show", "a.h5", "--json").out)["floor"] is None


def test_a_scene_that_was_changed_has_no_floor_and_says_so(springopt, mine: Path) -> None:
    springopt("floor", "mine.toml", "--starts", "2")
    mine.write_text(OUT_OF_REACH.replace("3.0", "3.5"))
    out = springopt(*SOLVE, "mine.toml").out
    assert "the floor that is stored belongs to another state of this scene" in out
    springopt("floor", "mine.toml", "--starts", "2")
    assert json.loads(Path("mine.floor.json").read_text())["point"] == [3.5]


def test_a_run_that_beats_the_floor_says_how_to_store_it(springopt, mine: Path) -> None:
    springopt("floor", "mine.toml", "--starts", "2")
    lowest = json.loads(Path("mine.floor.json").read_text())["value"]
    stored(value=2.0)
    out = springopt(*SOLVE, "mine.toml", "--out", "a.h5").out
    assert "below 2, the lowest value known so far; store it with springopt floor mine.toml --from a.h5" in out
    code, out, _ = springopt("floor", "mine.toml", "--from", "a.h5")
    assert code == 0
    assert "found by: random-search, seed 0, 20 evaluations" in out
    of_run = json.loads(Path("mine.floor.json").read_text())["value"]
    assert lowest < of_run < 2.0
    springopt("floor", "mine.toml", "--starts", "2")
    out = springopt("floor", "mine.toml", "--from", "a.h5").out
    assert f", which was kept: {of_run:.9g} is not lower" in out
    assert json.loads(Path("mine.floor.json").read_text())["value"] == lowest


def test_a_run_on_another_scene_is_no_floor_of_this_one(springopt, mine: Path) -> None:
    springopt(*SOLVE, "paper-fem-2d", "--out", "a.h5")
    code, _, err = springopt("floor", "mine.toml", "--from", "a.h5")
    assert code == 2
    assert "a.h5 is a run on another scene, or on another state of mine" in err
    assert not Path("mine.floor.json").exists()
