"""The axis of effects: each left out, by errors against another engine."""

from pathlib import Path

import numpy as np

from springopt.scene import load_scene
from springopt.tradeoff.axes.effects import AXIS
from springopt.tradeoff.point import Request

EXAMPLES = Path(__file__).parents[2] / "examples"


def test_a_soft_block_without_each_of_its_effects():
    setup = load_scene(EXAMPLES / "soft_block_on_plane.toml").build()
    found = AXIS.measure(setup, Request(0.2))
    of = {point.name: point for point in found.points}
    assert set(of) == {"everything", "gravity", "plane", "volume", "bending"}
    assert of["everything"].is_stated
    assert of["everything"].errors.max() < 1e-9
    assert of["volume"].error.value > 0.01
    assert of["bending"].errors.max() < 0.01
    assert of["plane"].failures == len(setup.cases)  # nothing holds the block then
    assert "mechanism" in of["plane"].why
    assert found.notes[1] == "exact kinematics stays: small displacements would leave plane out."


def test_only_what_is_asked_for_is_measured():
    setup = load_scene("paper-fem-2d").build()
    (point,) = AXIS.measure(setup, Request(0.1, only=frozenset([("without", "exact kinematics")]))).points
    assert 0.01 < point.error.value < 0.1  # what small displacements leave out of moderate loads


def test_times_of_motions_count_as_one_error_a_load_case():
    setup = load_scene(EXAMPLES / "step_response.toml").build()
    found = AXIS.measure(setup, Request(0.1))
    assert all(point.errors.shape == (len(setup.cases),) for point in found.points)
    assert [point.name for point in found.points] == ["everything", "damping"]
    assert np.all(found.points[1].errors > 0.05)


def test_a_scene_of_small_displacements_without_effects_has_nothing_to_leave_out():
    scene = load_scene("paper-fem-2d").model_copy(update={"kinematics": "linear"})
    assert "no effects" in AXIS.missing(scene)
    assert AXIS.missing(load_scene("paper-fem-2d")) is None
