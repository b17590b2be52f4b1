"""What each effect costs and changes, where it is known."""

from pathlib import Path

import pytest

from springopt.analysis.effect_shares import effect_shares
from springopt.analysis.point import choose_point
from springopt.scene import load_scene

EXAMPLES = Path(__file__).parents[2] / "examples"
TWO_WEIGHTS = """
extends = "paper-stiffness-2d"
title = "Two weights, and a cell modulus that does nothing"
effects = [
  { kind = "gravity", acceleration = [0.0, -0.1], mass = 0.5 },
  { kind = "gravity", acceleration = [0.1, 0.0], mass = 0.5 },
  { kind = "volume", modulus = 1e-9 },
]
[encoding]
parameters = [
  { name = "gravity-2.mass", lower = 0.1, upper = 1.0 },
  { name = "volume.modulus", lower = 0.0, upper = 1.0 },
]
"""


def measured(scene, accuracy=0.01):
    setup = load_scene(scene).build()
    return effect_shares(setup, choose_point(setup), accuracy=accuracy, seconds=0.0)


def test_an_effect_below_the_accuracy_is_named_and_one_above_is_not():
    shares = measured(EXAMPLES / "soft_block_on_plane.toml")
    by_name = {share.name: share for share in shares.shares}
    assert set(by_name) == {"gravity", "plane", "volume", "bending"}
    assert by_name["volume"].change == pytest.approx(0.223, abs=1e-3)
    assert by_name["bending"].change == pytest.approx(3.6e-4, abs=2e-5)
    assert by_name["plane"].lost["push"] == "mechanism"
    assert by_name["plane"].share is None
    assert [sentence.split()[0] for sentence in shares.said] == ["bending"]
    assert "small displacements would leave plane out" in shares.left_out["exact kinematics"]
    assert [s.split()[0] for s in measured(EXAMPLES / "soft_block_on_plane.toml", 0.5).said] == ["volume", "bending"]


def test_effects_of_one_kind_and_fitted_parameters_are_told_apart(tmp_path):
    path = tmp_path / "two.toml"
    path.write_text(TWO_WEIGHTS)
    by_name = {share.name: share for share in measured(path).shares}
    assert set(by_name) == {"gravity", "gravity-2", "volume", "exact kinematics"}
    assert by_name["gravity"].change > by_name["gravity-2"].change > 0.01
    assert 0.0 < by_name["volume"].change < 1.0
    assert by_name["exact kinematics"].change > 0.0


def test_masses_stay_where_something_moves():
    shares = measured(EXAMPLES / "step_response.toml")
    assert shares.left_out == {"inertia": "without masses nothing moves in time"}
    assert [share.name for share in shares.shares] == ["damping"]
