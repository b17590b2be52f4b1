"""The solver axis on small scenes: what tolerance, engine and kinematics cost and leave."""

from pathlib import Path

import numpy as np
import pytest

from springopt.scene import load_scene
from springopt.tradeoff.axes.solver import AXIS
from springopt.tradeoff.point import Request

SQUARE = """
title = "Nine nodes, pulled and pushed"

[lattice]
grid = [3, 3]

[reference]
kind = "spring"
stiffness = 4.0

[encoding]
kind = "homogeneous"
lower = 1.0
upper = 10.0

[load_cases]
train = [
  { name = "pull", hold = "left", push = { on = "right", force = [0.3, 0.0] } },
  { name = "shear", hold = "left", push = { on = "right", force = [0.0, 0.1] } },
]
"""


TORN = """
title = "Two cells of finite elements; the springs of the right one do not reach the left one"

[lattice]
nodes = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [0.0, 1.0], [1.0, 1.0], [2.0, 1.0]]
springs = [[0, 1], [3, 4], [0, 4], [1, 3], [1, 4], [2, 5]]
cells = [[0, 1, 4, 3], [1, 2, 5, 4]]
cell_type = "quad"

[reference]
kind = "fem"
young = 5.0
poisson = 0.3

[encoding]
kind = "real"
lower = 1.0
upper = 10.0

[load_cases]
train = [
  { name = "middle", hold = [0, 3], push = { on = [1, 4], force = [0.1, 0.0] } },
  { name = "right", hold = [0, 3], push = { on = [2, 5], force = [0.1, 0.0] } },
]
"""
EXAMPLES = Path(__file__).parents[3] / "examples"


@pytest.fixture(scope="module")
def findings(scene_of):
    return AXIS.measure(scene_of(SQUARE).build(), Request(4.0))


def series(findings, name):
    return [point for point in findings.points if point.series == name]


def test_errors_fall_with_the_tolerance_to_rounding(findings):
    for engine in ("lanes", "sparse"):
        points = series(findings, f"exact, {engine}")
        worst = np.array([point.errors.max() for point in points])
        tolerances = np.array([point.states["objective.tolerance"] for point in points])
        assert points[-1].name == "tolerance 1e-12"
        assert (np.diff(tolerances) < 0).all()
        assert (worst <= 10.0 * tolerances + 1e-15).all()
        assert (np.diff(worst) <= 1e-16).all()
        assert worst[-1] < 1e-14
        assert all(point.is_good for point in points)


def test_all_engines_agree_and_the_scene_knows_its_own_setting(findings):
    tightest = [point for point in findings.points if point.name == "tolerance 1e-12"]
    assert {point.series for point in tightest} >= {"exact, lanes", "exact, sparse"}
    assert max(point.errors.max() for point in tightest) < 1e-13
    assert [(point.series, point.name) for point in findings.points if point.is_stated] == [
        ("exact, lanes", "tolerance 1e-8")
    ]
    assert all(point.numbers["iterations"] >= 1 for point in findings.points)


def test_small_displacements_are_judged_by_exact_ones(findings):
    (point,) = series(findings, "linear, lanes")
    assert 1e-3 < point.error.value < 0.3
    assert point.states == {"kinematics": "linear"}


def test_what_was_drawn_and_how_it_is_judged_is_said(findings):
    assert "all load cases (2) of one candidate, at the reference's stiffness" in findings.notes[0]
    assert "drawn by chance from the box (seed 0)" in findings.notes[0]
    assert any("the engine sparse begins and SciPy polishes" in note for note in findings.notes)
    assert "single precision" in findings.notes[-1]


def test_engines_that_there_is_no_time_for_are_left_out_and_said_so(scene_of):
    findings = AXIS.measure(scene_of(SQUARE).build(), Request(1e-3))
    assert {point.series for point in findings.points} == {"exact, lanes", "linear, lanes"}
    assert sum("is left out" in note for note in findings.notes) == 2


def test_an_engine_that_is_slow_has_few_tolerances_and_the_scene_s_own(scene_of):
    findings = AXIS.measure(scene_of(SQUARE).build(), Request(1e-6))
    names = [point.name for point in findings.points if point.series == "exact, lanes"]
    assert names == ["tolerance 1e-4", "tolerance 1e-8", "tolerance 1e-12"]
    assert any(point.is_stated for point in findings.points)


def test_another_seed_draws_others_and_few_settings_can_be_asked_for(scene_of):
    setup = scene_of(SQUARE).build()
    only = frozenset({("exact, lanes", "tolerance 1e-4")})
    first, second = (AXIS.measure(setup, Request(0.5, seed=seed, only=only)).points for seed in (0, 1))
    assert [(point.series, point.name) for point in first] == [*only]
    assert first[0].errors[2:].tolist() != second[0].errors[2:].tolist()


def test_an_effect_without_an_expansion_leaves_small_displacements_out(scene_of):
    plane = 'effects = [{ kind = "plane", stiffness = 50.0, point = [0.0, -0.01], normal = [0.0, 1.0] }]\n'
    findings = AXIS.measure(scene_of(plane + SQUARE).build(), Request(0.5))
    assert not any(point.series.startswith("linear") for point in findings.points)
    assert any("small displacements would leave plane out" in note for note in findings.notes)
    assert max(p.errors.max() for p in findings.points if p.name == "tolerance 1e-12") < 1e-13


def test_a_load_case_that_is_a_mechanism_fails_every_setting_and_is_not_dropped(scene_of):
    findings = AXIS.measure(scene_of(TORN).build(), Request(0.5))
    for point in findings.points:
        # The other load case leaves it open where the right cell is, and is not judged.
        assert point.errors.tolist() == [np.inf]
        assert "mechanism in 1 of 2 solves" in point.why
    assert any("1 of 2 solves some modes carry no load and no stiffness" in note for note in findings.notes)
    assert any("were drawn" in note and "had no equilibrium" in note for note in findings.notes)
    assert any("there is no equilibrium (mechanism)" in note for note in findings.notes)


def test_scenes_with_times_or_without_end_have_it_not(scene_of):
    assert "times" in AXIS.missing(load_scene(EXAMPLES / "step_response.toml"))
    assert AXIS.missing(scene_of(SQUARE)) is None
    huge = SQUARE.replace("[3, 3]", "[200, 200]")
    assert "30,000 degrees of freedom, not 80,000" in AXIS.missing(scene_of(huge))
