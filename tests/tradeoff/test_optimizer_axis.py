"""The axis of optimizers: shares of the time, what is left of the way, and who fails or is left out."""

import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from strange_optimizers import install

from springopt.analysis.known_floor import stored_floors
from springopt.analysis.way import Way
from springopt.run import Improvement
from springopt.scene import load_scene
from springopt.tradeoff.axes.optimizer import AXIS, scale
from springopt.tradeoff.axes.optimizer.entrants import entrants_of
from springopt.tradeoff.axes.optimizer.places import name_of, places_of, seconds_of, without_repeats
from springopt.tradeoff.axes.optimizer.records import MOST_IMPROVEMENTS, thinned
from springopt.tradeoff.axes.optimizer.runs import Attempt, race
from springopt.tradeoff.axes.optimizer.said import notes_on
from springopt.tradeoff.point import Request

DATA = Path(__file__).parents[1] / "data"


@pytest.fixture(scope="module")
def nine():
    return load_scene(DATA / "nine-nodes.toml").build()


@pytest.fixture(scope="module")
def isotropic():
    return load_scene("paper-stiffness-2d").build()


def of_series(found, name):
    return [point for point in found.points if point.series == name]


def test_what_is_left_falls_with_the_time_and_is_never_negative(monkeypatch, isotropic):
    install(monkeypatch, "random-search", "gauss-newton")
    found = AXIS.measure(isotropic, Request(1.5))
    least = found.numbers["least_error"]
    assert {point.series for point in found.points} == {"random-search", "gauss-newton"}
    for name in ("random-search", "gauss-newton"):
        points = of_series(found, name)
        medians = [point.error.value for point in points]
        assert medians == sorted(medians, reverse=True)
        assert all((point.errors >= least).all() and point.is_good for point in points)
        times = [point.processor_seconds.high for point in points]
        assert times == sorted(times)
    assert of_series(found, "gauss-newton")[-1].error.value == least  # a proven zero, and no logarithm of it
    assert any(note.startswith("First by the median of its runs: gauss-newton below 10 %") for note in found.notes)
    assert any(note.startswith("Errors are not below") for note in found.notes)


def test_overhead_and_solves_are_all_that_a_run_takes(monkeypatch, nine):
    install(monkeypatch, "random-search", "gauss-newton")
    found = AXIS.measure(nine, Request(0.5))
    for run in found.numbers["runs"]:
        assert run["overhead_seconds"] + run["solving_seconds"] == pytest.approx(run["processor_seconds"])
        assert 0 < run["solving_seconds"] <= run["processor_seconds"]
        assert run["evaluations"] <= nine.scene.budget.evaluations
        spent = [each["processor_seconds"] for each in run["improvements"]]
        errors = [each["error"] for each in run["improvements"]]
        assert spent == sorted(spent)
        assert errors == sorted(errors, reverse=True)
        assert errors[-1] == run["error"]
    seeds = [run["seed"] for run in found.numbers["runs"] if run["optimizer"] == "random-search"]
    assert seeds == list(range(len(seeds)))


def test_what_fails_is_a_point_and_what_can_not_serve_a_sentence(monkeypatch, nine):
    install(monkeypatch, "random-search", "rogue", "bits", "shy")
    found = AXIS.measure(nine, Request(0.3))
    (rogue,) = of_series(found, "rogue")
    assert rogue.error is None
    assert rogue.failures == len(rogue.errors) == 1  # once is enough
    assert "out of luck" in rogue.why
    assert rogue.processor[0] > 0
    assert "Left out for lack of a binary encoding: bits; for memory: shy." in found.notes
    assert {point.series for point in found.points} == {"rogue", "random-search"}


def test_without_a_stored_floor_the_lowest_value_takes_its_place(monkeypatch, nine):
    install(monkeypatch, "random-search", "middle")
    found = AXIS.measure(nine, Request(0.3))
    assert found.numbers["floor"] == min(run["objective"] for run in found.numbers["runs"])
    (note,) = (note for note in found.notes if note.startswith("No floor of nine-nodes is stored here"))
    assert "springopt floor nine-nodes.toml" in note
    # The one value of what is content at once, at the time that it took.
    (middle,) = of_series(found, "middle")
    assert middle.numbers["evaluations"] == 1
    assert (middle.processor <= seconds_of(middle.name)).all()


def test_a_floor_that_a_run_went_below_gives_way(monkeypatch, isotropic):
    install(monkeypatch, "gauss-newton")
    (stored,) = stored_floors("paper-stiffness-2d", [])
    beaten = replace(stored, proof=None, value=0.5 * stored.start)
    monkeypatch.setattr(scale, "stored_floors", lambda name, folders: [beaten])
    found = AXIS.measure(isotropic, Request(0.3))
    assert found.numbers["floor"] < beaten.value
    assert any("went below the floor of paper-stiffness-2d" in note for note in found.notes)


def test_the_times_that_are_asked_for_are_those_that_come(monkeypatch, isotropic):
    install(monkeypatch, "gauss-newton", "random-search")
    (point,) = AXIS.measure(isotropic, Request(0.3, seed=1, only=frozenset([("gauss-newton", "500 ms")]))).points
    assert (point.series, point.name) == ("gauss-newton", "500 ms")
    assert point.is_good


def test_a_run_that_verifies_is_judged_by_the_lowest_floor_that_was_known(monkeypatch, nine):
    install(monkeypatch, "random-search")
    only = frozenset([("random-search", "1 s")])
    alone, judged = (
        AXIS.measure(nine, Request(0.1, seed=1, only=only, before=before)) for before in ({}, {"floor": 0.0})
    )
    assert alone.points[0].errors.min() == alone.numbers["least_error"]  # nobody else is there to be lower
    assert judged.numbers["floor"] == 0.0
    assert judged.points[0].errors.min() > 1e3 * judged.numbers["least_error"]


def test_a_scene_states_a_run_by_options_and_a_budget(monkeypatch, nine):
    install(monkeypatch, "random-search", "middle")
    found = AXIS.measure(nine, Request(2.0))
    (stated,) = (point for point in found.points if point.is_stated)
    assert stated is of_series(found, "random-search")[-1]


def test_the_first_round_is_complete_and_steps_that_no_clock_ends_are_told(nine):
    entrants, _ = entrants_of(nine, ["random-search"])
    raced = race(nine, entrants, seed=0, until=time.perf_counter() - 1.0, limit=0.1, progress=None)
    assert [each.optimizer for each in raced.attempts] == ["random-search"]
    late = replace(raced, attempts=[replace(raced.attempts[0], wall=9.0)])
    assert any("Single steps of random-search" in note for note in notes_on(late, [], Way(1.0, "it", 0.0, True), 1, {}))


def attempt(ends, *, is_cut, first=0.003):
    run = type("Run", (), {"history": [Improvement(1, 1, first, first, 2.0), Improvement(9, 9, 0.03, 0.03, 1.0)]})()
    return Attempt("a", 0, ends, ends, run, is_cut)


def test_times_go_from_the_first_answers_to_where_the_first_run_is_stopped():
    attempts = [attempt(0.127, is_cut=True), attempt(0.3, is_cut=False, first=0.006)]
    assert [name_of(place) for place in places_of(attempts)] == ["10 ms", "20 ms", "50 ms", "120 ms"]
    content = [attempt(0.127, is_cut=False), attempt(0.3, is_cut=False)]
    assert places_of(content)[-1] == pytest.approx(0.3)
    assert places_of([Attempt("a", 0, 1.0, 1.0, None, why="no")]) == []


def test_a_run_has_at_a_time_what_it_found_before():
    whole = attempt(0.127, is_cut=True)
    assert whole.best_at(0.002) is None
    assert whole.best_at(0.003).value == 2.0
    assert whole.best_at(5.0).value == 1.0


@pytest.mark.parametrize("seconds", [5e-5, 0.0081, 0.12, 1.5, 60.0])
def test_a_time_has_a_name_that_tells_it(seconds):
    assert seconds_of(name_of(seconds)) == pytest.approx(seconds)


def test_times_at_which_nothing_came_of_the_time_are_left_out():
    assert without_repeats([1, 2, 3, 4, 5], [np.inf, 1.0, 0.99, 0.5, 0.5], change=0.05) == [2, 4, 5]


def test_few_improvements_of_a_long_run_are_written_down():
    values = np.geomspace(1.0, 1e-3, 2000)
    history = [Improvement(n, n, 0.001 * n, 0.001 * n, value) for n, value in enumerate(values, start=1)]
    run = type("Run", (), {"history": history})()
    kept = thinned(run, Way(1.0, "by hand", 0.0, True), 1e-9)
    assert len(kept) <= MOST_IMPROVEMENTS + 1
    assert (kept[0], kept[-1]) == (history[0], history[-1])
