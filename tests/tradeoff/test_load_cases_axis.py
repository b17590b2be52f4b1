"""The axis of load cases: what more of them are worth, given and designed, and that no test is learned from."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from strange_optimizers import install

from springopt.errors import UserError
from springopt.scene import load_scene
from springopt.tradeoff.axes.load_cases import AXIS, sets
from springopt.tradeoff.axes.load_cases.identification import choose_method, identify
from springopt.tradeoff.axes.load_cases.sets import DESIGNED, GIVEN, Design, designed, given, run_design
from springopt.tradeoff.point import Request

DATA = Path(__file__).parents[1] / "data"
EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.fixture(scope="module")
def noisy():
    return load_scene("recovery-2d-sparse-noisy").build()


@pytest.fixture(scope="module")
def nine():
    return load_scene(DATA / "nine-nodes.toml").build()


@pytest.fixture(scope="module")
def of_noisy(noisy):
    return AXIS.measure(noisy, Request(6.0))


def by_count(found, series):
    return {point.numbers["load_cases"]: point for point in found.points if point.series == series}


def test_errors_fall_with_the_number_of_load_cases_where_there_is_noise(of_noisy):
    own, picked = by_count(of_noisy, GIVEN), by_count(of_noisy, DESIGNED)
    assert list(own) == [2, 4, 6, 8, 12]
    assert list(picked) == [2, 4, 6, 8, 12, 16]
    assert own[12].error.value < 0.6 * own[2].error.value
    assert picked[16].error.value < 0.6 * picked[2].error.value
    assert own[12].is_stated
    assert sum(point.is_stated for point in of_noisy.points) == 1
    assert (own[2].numbers["unidentified"], own[12].numbers["unidentified"]) == (4, 0)
    assert own[12].numbers["solves"] > own[2].numbers["solves"]
    assert all(point.is_good for point in of_noisy.points)
    assert of_noisy.numbers["identified_by"] == "gauss-newton"


def test_every_repeat_has_an_error_in_each_test_load_case(noisy, of_noisy):
    tests = sum(case.role == "test" for case in noisy.cases)
    assert all(len(point.errors) == tests * len(point.processor) for point in of_noisy.points)


def test_picks_differ_and_no_test_load_case_is_learned_from(noisy):
    found = run_design(noisy)
    names = [case.name for case in found.picks]
    assert len(set(names)) == len(names) == 15
    tests = [case for case in noisy.cases if case.role == "test"]
    every = [*given(noisy), *designed(noisy, found)]
    for each in every:
        assert len({case.name for case in each.training}) == each.count
        assert not {case.name for case in each.training} & {case.name for case in tests}
        assert not any(sets._is_same(case, test) for case in each.training for test in tests)
        assert [case for case in each.setup.cases if case.role == "test"] == tests
        assert each.setup.objective.cases == each.setup.cases
    assert every[4].setup.cases == noisy.cases
    np.testing.assert_array_equal(every[4].setup.reference_positions, noisy.reference_positions)


def test_a_picked_load_case_of_the_scene_is_as_noisy_as_it_was(noisy):
    second = next(number for number, case in enumerate(noisy.cases) if number and case.role == "train")
    (pair,) = designed(noisy, Design("", [noisy.cases[second]], 1, []))
    np.testing.assert_array_equal(pair.setup.reference_positions[:2], noisy.reference_positions[[0, second]])


def test_weights_stay_with_their_load_cases(nine):
    weighted = replace(nine, objective=replace(nine.objective, weights=np.array([3.0, 5.0, 1.0])))
    first, both = given(weighted)
    assert first.setup.objective.weights.tolist() == [3.0, 1.0]
    assert both.setup.objective.weights.tolist() == [3.0, 5.0, 1.0]
    value = both.setup.objective.evaluate(np.full((1, 20), 4.0)).values
    np.testing.assert_array_equal(value, weighted.objective.evaluate(np.full((1, 20), 4.0)).values)


def test_a_load_case_without_an_answer_of_the_reference_is_left_out(monkeypatch, nine):
    reference = nine.objective.reference
    first = run_design(nine).picks[0].name

    class Broken:
        def deform(self, case):
            if case.name == first:
                raise UserError("no answer")
            return reference.deform(case)

    found = run_design(replace(nine, objective=replace(nine.objective, reference=Broken())))
    assert list(found.left_out) == [first]
    assert first not in [case.name for case in found.picks]


def test_a_test_load_case_at_another_size_is_the_same(nine):
    press = nine.cases[2]
    assert sets._is_same(press, replace(press, forces=-0.3 * press.forces))
    assert not sets._is_same(press, nine.cases[0])
    assert not sets._is_same(press, replace(press, forces=press.forces + 0.1))


def test_only_what_is_asked_for_is_measured(noisy):
    found = AXIS.measure(noisy, Request(0.5, seed=1, only=frozenset([(GIVEN, "4 load cases")])))
    assert [(point.series, point.name) for point in found.points] == [(GIVEN, "4 load cases")]
    assert "design_seconds" not in found.numbers


def test_bits_are_found_by_as_many_evaluations_on_every_set(monkeypatch):
    monkeypatch.setattr("springopt.tradeoff.axes.load_cases.identification._affordable", lambda *_: 300)
    setup = load_scene("paper-topology-2d-isotropic").build()
    found = AXIS.measure(setup, Request(4.0, only=frozenset([(GIVEN, "2 load cases"), (GIVEN, "8 load cases")])))
    few, many = found.points
    assert found.numbers["identified_by"] == "paper-ga"
    assert few.numbers["evaluations"] == many.numbers["evaluations"] == 300
    assert many.numbers["solves"] == 4 * few.numbers["solves"]
    assert few.numbers["unidentified"] == 4
    assert found.notes[0] == "Identified by paper-ga (300 evaluations), once for each seed."
    monkeypatch.setattr("springopt.tradeoff.axes.load_cases.identification._affordable", lambda *_: 900)
    request = Request(0.1, seed=1, only=frozenset([(GIVEN, "2 load cases")]), before=found.numbers)
    again = AXIS.measure(setup, request)  # a setting that is verified has no more of them
    assert again.points[0].numbers["evaluations"] == 300
    assert again.numbers["seconds_a_load_case"] == found.numbers["seconds_a_load_case"]


def test_motions_are_judged_at_all_their_times():
    setup = load_scene(DATA / "nine-nodes-in-motion.toml").build()
    found = AXIS.measure(setup, Request(2.0))
    assert {point.series for point in found.points} == {GIVEN, DESIGNED}
    assert all(len(point.errors) == len(point.processor) for point in found.points)
    own, picked = by_count(found, GIVEN)[2], by_count(found, DESIGNED)[4]
    assert own.numbers["unidentified"] == 2
    assert picked.numbers["unidentified"] == 0
    assert picked.error.value < 0.1 * own.error.value


def test_an_identification_that_fails_is_a_point(monkeypatch, nine):
    install(monkeypatch, "rogue")
    monkeypatch.setattr("springopt.tradeoff.axes.load_cases.identification.CHOICES", {"rogue": {}})
    found = AXIS.measure(nine, Request(0.2, only=frozenset([(GIVEN, "2 load cases")])))
    (point,) = found.points
    assert point.error is None
    assert "out of luck" in point.why


def test_the_strongest_optimizer_that_serves_is_chosen(monkeypatch, nine):
    assert choose_method(nine, 1.0).optimizer.name == "gauss-newton"
    install(monkeypatch, "shy", "l-bfgs-b", "random-search")
    choices = {"shy": {}, "l-bfgs-b": {"starts": 1}, "random-search": {}}
    monkeypatch.setattr("springopt.tradeoff.axes.load_cases.identification.CHOICES", choices)
    assert choose_method(nine, 1.0).optimizer.name == "l-bfgs-b"


def test_many_unknowns_are_found_by_gradients_and_not_designed_for(monkeypatch, nine):
    monkeypatch.setattr("springopt.tradeoff.axes.load_cases.identification.LARGE", 100)
    monkeypatch.setattr(sets, "TOO_MUCH_WORK", 1e3)
    found = AXIS.measure(nine, Request(0.5))
    assert found.numbers["identified_by"] == "l-bfgs-b"
    assert {point.series for point in found.points} == {GIVEN}
    assert "There is no series designed: 20 unknowns are too many for a design of 3 load cases" in found.notes[1]


def test_a_start_that_takes_the_whole_budget_is_no_warning(nine):
    method = replace(choose_method(nine, 1.0), evaluations=1)
    assert method.start == "analytic"
    ((found,),) = identify(list(given(nine))[-1:], method, [1.0], Request(0.1), 0.0)
    assert found.run.evaluations == 1


def test_a_scene_without_test_load_cases_lacks_the_axis():
    assert "no test load cases" in AXIS.missing(load_scene(EXAMPLES / "one_side_held.toml"))
    assert AXIS.missing(load_scene("paper-fem-2d")) is None
