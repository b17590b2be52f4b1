"""Axes in turn: shares of the seconds, what is missing, where to spend, and the document of it all."""

import json
import re
import sys
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from axis_of_words import axis_of, point

from springopt.errors import UserError
from springopt.scene import load_scene
from springopt.tradeoff.advice import advise
from springopt.tradeoff.axes import MODULES, choose_axes
from springopt.tradeoff.document import document
from springopt.tradeoff.errors import relative_errors
from springopt.tradeoff.measure import measure


class Stage:
    """All of a setup that axes of words look at."""

    scene = load_scene("paper-fem-2d")


def found_of(*axes):
    return measure(Stage(), axes, seconds=8.0)


def test_the_seconds_are_shared_and_what_one_leaves_goes_to_the_others():
    (first, asked_first), (second, asked_second) = (axis_of([point("a", 1.0, 1.0)]) for _ in range(2))
    found_of(first, second)
    assert asked_first[0].seconds == pytest.approx(4.0, rel=0.01)
    assert asked_second[0].seconds == pytest.approx(8.0, rel=0.01)


def test_an_axis_that_others_left_no_time_has_some_even_so(monkeypatch):
    clock = SimpleNamespace(perf_counter=iter(range(0, 1000, 100)).__next__)
    monkeypatch.setattr(sys.modules[measure.__module__], "time", clock)
    axes = [axis_of([point("a", 1.0, 1.0)]) for _ in range(2)]
    found_of(*(axis for axis, _ in axes))
    assert [asked[0].seconds for _, asked in axes] == [1.0, 1.0]


def test_an_axis_that_a_scene_lacks_is_named_with_the_reason():
    there, lacking = axis_of([point("a", 1.0, 1.0)])[0], axis_of([], name="none", missing="it has no such thing")[0]
    assert found_of(there, lacking).missing == {"none": "it has no such thing"}
    with pytest.raises(UserError, match="has none of these axes \\(none: it has no such thing\\)"):
        found_of(lacking)


def test_an_axis_that_there_is_not_is_refused_with_a_hint():
    with pytest.raises(UserError, match=r"there is no axis 'solvr'.*Did you mean 'solver'"):
        choose_axes(["solvr"])


def test_every_axis_has_the_name_that_it_is_called_by():
    assert [axis.name for axis in choose_axes()] == list(MODULES)


def spending():
    model = axis_of([point("few", 0.2, 1.0), point("stated", 0.1, 2.0, is_stated=True)], name="model")[0]
    solver = axis_of(
        [point("loose", 1e-4, 1.0), point("looser", 1e-2, 0.5), point("stated", 1e-9, 3.0, is_stated=True)],
        name="solver",
    )[0]
    return found_of(solver, model)


def test_the_largest_error_is_where_to_spend_and_what_is_unseen_beside_it_may_be_cheaper():
    said = advise(spending())
    assert said[0] == "As the scene states it, positions are off by 0.1 (model), 1e-09 (solver) of the displacements."
    assert said[1].startswith("The largest part is that of the model: spend there, one digit more costs 10 times")
    assert said[2] == "solver: s, loose would do (its error is below 1% of that) and takes 0.33 of the time."


def test_one_axis_alone_says_nothing_of_the_others():
    stated = axis_of([point("stated", 0.1, 1.0, is_stated=True)])[0]
    gap = axis_of([point("stated", 0.1, 1.0, is_stated=True)], name="gap", is_part=False)[0]
    assert advise(found_of(stated, gap)) == []


def test_nothing_is_spent_on_an_axis_without_grades_but_it_may_save():
    model = axis_of([point("few", 0.2, 1.0), point("stated", 0.1, 2.0, is_stated=True)], name="model")[0]
    choices = [point("stated", 1e-7, 2.0, is_stated=True), point("gravity", 1e-4, 1.0)]
    effects = axis_of(choices, name="effects", is_graded=False)[0]
    assert advise(found_of(effects, model)) == [
        "As the scene states it, positions are off by 0.1 (model) of the displacements.",
        "effects: s gravity would do (its error is below 1% of that) and takes 0.5 of the time.",
    ]


def test_a_fit_that_the_time_ended_is_no_error_of_the_model_for_sure():
    cut = replace(point("stated", 0.1, 2.0, is_stated=True), numbers={"fit_is_cut": 1.0})
    axes = [axis_of([each])[0] for each in (cut, point("stated", 1e-9, 1.0, is_stated=True))]
    assert advise(found_of(*axes))[-1].startswith("But the time ended its fit")
    cheaper = point("loose", 1e-6, 0.1)
    axes[1] = axis_of([cheaper, point("stated", 1e-9, 1.0, is_stated=True)])[0]
    assert advise(found_of(*axes))[-1].startswith("But the time ended its fit")


def test_errors_that_nobody_misses_are_nothing_to_spend_on():
    axes = [axis_of([point("stated", error, 1.0, is_stated=True)], name=str(error))[0] for error in (1e-9, 1e-12)]
    assert advise(found_of(*axes))[-1] == "That is nothing to spend on."


def test_settings_that_are_not_graded_have_no_price():
    points = [point("a", 1e-2, 1.0), point("b", 1e-4, 2.0)]
    graded, choices = found_of(axis_of(points)[0], axis_of(points, is_graded=False)[0]).measured
    assert graded.price is not None
    assert list(graded.prices) == ["s"]
    assert choices.price is None
    assert choices.prices == {}


def test_the_document_is_json_and_names_failures_front_and_price():
    points = [point("bad", [np.inf], 0.5), point("half", [1e-3, np.inf], 1.0), point("good", 1e-3, 2.0)]
    found = found_of(axis_of(points)[0])
    answer = json.loads(json.dumps(document(Stage.scene, found), allow_nan=False))
    (axis,) = answer["axes"]
    bad, half, good = axis["points"]
    assert (bad["error"], bad["failures"], bad["on_front"]) == (None, 1, False)
    assert (half["failures"], half["answers"], half["on_front"]) == (1, 2, False)
    assert good["on_front"]
    assert good["repeats"] == 6
    assert axis["notes"] == ["A note."]
    assert re.fullmatch(r"\d+\.\d+.*", answer["machine"]["springopt"])


def test_errors_are_shares_of_the_mean_displacement():
    nodes = np.array([[0.0, 0.0], [1.0, 0.0]])
    known = nodes + np.array([[[0.0, 0.3], [0.0, 0.1]], [[0.0, 0.0], [0.0, 0.0]]])
    positions = known + np.array([0.03, 0.04])
    np.testing.assert_allclose(relative_errors(positions, known, nodes), [0.05 / 0.2, 0.05 / 1.0])
