"""The stepping axis on an oscillator and on the sheet of the examples."""

from pathlib import Path

import numpy as np
import pytest

from springopt.scene import load_scene
from springopt.tradeoff.axes.stepping import AXIS
from springopt.tradeoff.point import Request

SWING = """
title = "Nine nodes that are let go"
effects = [{ kind = "inertia", mass = 1.0 }]

[lattice]
grid = [3, 3]

[reference]
kind = "spring"
stiffness = 4.0

[stepping]
step = 0.2

[encoding]
kind = "homogeneous"
lower = 1.0
upper = 10.0

[load_cases]
times = { until = 2.4, count = 1 }
train = [
  { name = "pull", hold = "left", push = { on = "right", force = [0.05, 0.0] } },
]
"""
EXAMPLES = Path(__file__).parents[3] / "examples"


@pytest.fixture(scope="module")
def findings(scene_of):
    return AXIS.measure(scene_of(SWING).build(), Request(2.0))


@pytest.mark.parametrize("integrator", ["energy-momentum", "l-stable"])
def test_errors_fall_with_the_square_of_the_step(findings, integrator):
    points = [point for point in findings.points if point.series == integrator]
    steps = np.array([point.states["stepping.step"] for point in points])
    errors = np.array([point.errors[0] for point in points])
    is_fine = steps <= 0.05
    assert np.count_nonzero(is_fine) >= 2
    assert np.polyfit(np.log(steps[is_fine]), np.log(errors[is_fine]), 1)[0] == pytest.approx(2.0, abs=0.1)
    (said,) = [note for note in findings.notes if note.startswith(f"The observed order of {integrator} is ")]
    assert float(said.split()[6].rstrip(",")) == pytest.approx(2.0, abs=0.1)
    counts = [point.numbers["steps"] for point in points]
    assert counts[steps.tolist().index(0.2)] == 12.0


def test_a_smaller_step_error_makes_smaller_errors(findings):
    points = [point for point in findings.points if point.series == "energy-momentum, adaptive"]
    assert len(points) >= 3
    assert points[-1].errors[0] < 0.1 * points[0].errors[0]
    assert points[0].states["stepping.step_error"] == 1e-2


def test_the_setting_of_the_scene_is_its_own(findings):
    assert [(point.series, point.name) for point in findings.points if point.is_stated] == [
        ("energy-momentum", "step 0.2")
    ]


def test_the_limit_of_explicit_stepping_is_marked_where_a_step_of_its_length_costs(findings):
    (mark,) = findings.marks
    step = float(mark.removeprefix("explicit limit: step "))
    # Gershgorin: no mode is faster than twice the stiffness that meets at a node over its mass.
    assert 2.0 / np.sqrt(2.0 * 4.0 * 8.0) < step < 2.0 / np.sqrt(4.0)
    points = [point for point in findings.points if point.series == "energy-momentum"]
    times = [point.processor_seconds.value for point in points]
    assert min(times) <= findings.marks[mark] <= max(times)
    assert any("unstable above a step of" in note for note in findings.notes)


def test_a_step_error_that_the_scene_states_is_measured_as_it_is(scene_of):
    scene = scene_of(SWING.replace("step = 0.2", "step = 0.25\nstep_error = 2e-4"))
    only = frozenset({("energy-momentum, as stated", "step error 2e-4")})
    (point,) = AXIS.measure(scene.build(), Request(0.2, only=only)).points
    assert point.is_stated
    assert point.states["stepping.step"] == 0.25


def test_steps_that_end_on_the_same_times_are_measured_once(scene_of):
    scene = scene_of(SWING.replace("step = 0.2", "step = 1.2"))
    findings = AXIS.measure(scene.build(), Request(0.2))
    names = [point.name for point in findings.points]
    # Four times the scene's own would end on the one time of its motion in one step, as twice does.
    assert "step 2.4" in names
    assert "step 4.8" not in names


def test_steps_that_are_shorter_because_they_end_on_the_times_say_so(scene_of):
    scene = scene_of(SWING.replace("step = 0.2", "step = 1.0"))
    names = [point.name for point in AXIS.measure(scene.build(), Request(0.2)).points]
    assert {"step 4 (2.4 taken)", "step 2 (1.2 taken)", "step 1 (0.8 taken)"} <= set(names)


def test_scenes_without_times_or_masses_have_it_not(scene_of):
    assert AXIS.missing(load_scene("paper-fem-2d")) == "its load cases have no times"
    assert AXIS.missing(load_scene(EXAMPLES / "step_response.toml")) is None
    massless = SWING.replace("mass = 1.0", "mass = [1, 1, 1, 1, 0, 1, 1, 1, 1]").replace(
        "step = 0.2", 'step = 0.2\nintegrator = "l-stable"'
    )
    assert "node 4 moves in load case 'pull' and has no mass" in AXIS.missing(scene_of(massless))
