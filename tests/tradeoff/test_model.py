"""The axis *model*: what identifying, solving and moving variations of a scene finds."""

import json
import time
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from springopt.errors import SceneError
from springopt.lattice import SpringLattice, side
from springopt.scene import Scene
from springopt.tradeoff.axes.model import AXIS, findings, identification
from springopt.tradeoff.axes.model.largest import Size, Sizes, largest_that_keeps, stage
from springopt.tradeoff.axes.model.real_time import Step, clockwork, moving, slowest_period, time_step
from springopt.tradeoff.axes.model.resampling import resampled, why_fixed
from springopt.tradeoff.axes.model.resolution import fine_positions, resolutions, traction_shares
from springopt.tradeoff.axes.model.running import Running
from springopt.tradeoff.axes.model.variation import encodings, neighbourhoods, on_same_nodes, with_encoding
from springopt.tradeoff.interval import Interval
from springopt.tradeoff.point import Request

FEM = {"kind": "fem", "young": 10.0, "poisson": 0.3}
PULL = {"name": "pull", "hold": "left", "push": {"on": "right", "force": [0.2, 0.0]}}
SHEAR = {"name": "shear", "hold": "bottom", "push": {"on": "top", "force": [0.1, 0.0]}}
BACK = {"name": "back", "hold": "right", "push": {"on": "left", "force": [0.0, -0.05]}}
CORNER = {"name": "corner", "hold": "left", "push": {"on": 8, "force": [0.1, 0.1]}}


def scene(**tables):
    """Nine nodes, three load cases to learn from and one that judges."""
    basis = {
        "name": "nine",
        "title": "Nine nodes",
        "lattice": {"grid": [3, 3]},
        "reference": FEM,
        "encoding": {"kind": "real", "upper": 10.0},
        "load_cases": {"train": [PULL, SHEAR, BACK], "test": [CORNER]},
    }
    return Scene.from_json(json.dumps(basis | tables))


def classes_reference():
    """Stiffness of nine nodes whose straight springs have 4 and diagonals 2."""
    straight = SpringLattice.grid([3, 3]).straight
    return {"kind": "spring", "stiffness": np.where(straight, 4.0, 2.0).tolist()}


def soon(seconds):
    return time.perf_counter() + seconds


@pytest.fixture(scope="module")
def found():
    return AXIS.measure(scene().build(), Request(4.0))


def points_of(findings, series):
    return {point.name: point for point in findings.points if point.series == series}


def test_more_freedom_is_never_worse_in_training(found):
    points = points_of(found, "encodings")
    names = ("homogeneous", "two-class", "three-class", "free")
    misfits = [points[name].numbers["training_misfit"] for name in names]
    assert all(more <= less * (1 + 1e-6) for less, more in pairwise(misfits))


def test_every_setting_has_its_errors_times_and_numbers(found):
    assert {point.series for point in found.points} >= {"encodings", "neighbourhood", "resolution, free"}
    for point in found.points:
        assert len(point.errors) == 1  # the one test load case
        assert len(point.processor)
        assert len(point.wall) == len(point.processor)
        assert point.numbers["unknowns"] >= 1
        assert bool(point.why) <= (point.failures > 0 or not np.isfinite(point.numbers["training_misfit"]))


def test_what_the_scene_states_is_marked(found):
    stated = {(point.series, point.name) for point in found.points if point.is_stated}
    assert stated == {("encodings", "free"), ("neighbourhood", "moore"), ("resolution, free", "3 x 3 nodes")}


def test_fewer_springs_have_larger_errors():
    free = [each for each in encodings(scene().build()).of if each.name == "free"]
    (whole,) = identification.identify(free, Request(5.0), soon(5.0))
    sparse, notes = identification.sparser(whole, Request(60.0), soon(60.0))  # the path ends long before
    assert len(sparse) >= 3
    assert not notes
    bodies = [Running.of(each.setup, each.row) for each in sparse]
    springs = [body.spring_count for body in bodies]
    misfits = [body.misfits(body.solve())[~body.is_test()].sum() for body in bodies]
    assert springs == sorted(set(springs), reverse=True)
    assert springs == [each.unknowns for each in sparse]
    assert misfits == sorted(misfits)
    assert all(count <= int(each.variation.name.split()[2]) for count, each in zip(springs, sparse, strict=True))


def test_rates_are_said_and_numbered(found):
    for rate in ("1 kHz", "60 Hz"):
        assert any(note.startswith(f"{rate} is kept by") for note in found.notes)
        assert rate in found.numbers["real_time"]
    sizes = found.numbers["step_seconds_by_springs"]
    assert sizes
    assert all(seconds > 0 for seconds in sizes.values())


def test_what_the_time_does_not_allow_is_left_out():
    late = time.perf_counter() - 1.0
    assert len(identification.identify(encodings(scene().build()).of, Request(1.0), late)) == 1


def test_two_classes_of_a_reference_of_two_classes_are_exact():
    setup = scene(reference=classes_reference()).build()
    two = [each for each in encodings(setup).of if each.name == "two-class"]
    (one,) = identification.identify(two, Request(2.0), soon(2.0))
    body = Running.of(one.setup, one.row)
    assert body.errors(body.solve()).max() < 1e-6


def test_a_reference_of_springs_keeps_its_own_springs_in_every_neighbourhood():
    setup = scene(reference=classes_reference()).build()
    varied = neighbourhoods(setup)
    assert [each.name for each in varied.of] == ["von-neumann", "moore", "moore, radius 2"]
    assert all(each.setup.reference_positions is setup.reference_positions for each in varied.of)
    assert "because its reference is no finite element mesh" in resolutions(setup).notes[0]


def test_classes_without_springs_are_noted():
    setup = scene(lattice={"grid": [3, 3], "neighbourhood": "von-neumann"}).build()
    names = [each.name for each in encodings(setup).of]
    assert names == ["homogeneous", "free"]
    assert any("two-class" in note and "diagonal" in note for note in encodings(setup).notes)


def test_a_mesh_has_edges_and_cells():
    lattice = SpringLattice.grid([3, 3], neighbourhood="von-neumann")
    tables = {
        "nodes": lattice.nodes.tolist(),
        "springs": lattice.springs.tolist(),
        "cells": lattice.cells.tolist(),
        "cell_type": "quad",
    }
    varied = neighbourhoods(scene(lattice=tables).build()).of
    assert [(each.name, each.setup.lattice.spring_count, each.is_stated) for each in varied] == [
        ("edges", 12, True),
        ("cells", 20, False),
    ]


def test_bits_get_a_free_stiffness_beside_them():
    bits = scene(encoding={"kind": "binary", "stiffness": 5.0}).build()
    varied = encodings(bits)
    assert [each.name for each in varied.of if each.is_stated] == ["binary"]
    free = with_encoding(bits.scene, "real").encoding
    assert (free.lower, free.upper) == (0.0, 10.0)
    assert any("2 times" in note for note in varied.notes)


def test_without_test_load_cases_training_errors_judge():
    setup = scene(load_cases={"train": [PULL, SHEAR]}).build()
    request = Request(1.0, only=frozenset({("encodings", "homogeneous")}))
    result = AXIS.measure(setup, request)
    assert len(result.points) == 1
    assert len(result.points[0].errors) == 2
    assert "test_misfit" not in result.points[0].numbers
    assert any("no test load cases" in note for note in result.notes)


def test_without_plugins_the_core_fits_and_says_what_is_missing(monkeypatch):
    monkeypatch.setattr(identification, "installed", lambda: [])
    monkeypatch.setattr("springopt.analysis.fit.installed", lambda: ["random-search"])
    setup = scene(reference=classes_reference()).build()
    result = AXIS.measure(setup, Request(2.0, only=frozenset({("encodings", "free"), ("sparsity", "any")})))
    assert [point.name for point in result.points] == ["free"]
    assert result.points[0].error.value < 1e-3
    assert any("sparse-path is not installed" in note for note in result.notes)


def test_a_model_without_equilibrium_is_a_failure_that_says_why():
    setup = scene(lattice={"grid": [3, 3], "neighbourhood": "von-neumann"}, kinematics="linear").build()
    request = Request(1.0, only=frozenset({("encodings", "homogeneous")}))
    (point,) = AXIS.measure(setup, request).points
    assert point.failures == 1
    assert point.error is None
    assert "corner: mechanism" in point.why


def test_absent_springs_do_not_run_and_change_no_answer():
    setup = scene().build()
    row = np.where(np.arange(setup.lattice.spring_count) == 3, 0.0, 4.0)
    body = Running.of(setup, row)
    assert body.model.lattice.spring_count == setup.lattice.spring_count - 1
    whole = replace(body, model=setup.model, row=row)
    np.testing.assert_allclose(body.solve().displacements, whole.solve().displacements, atol=1e-8)


def test_springs_stay_where_effects_are_stated_one_by_one():
    bent = scene(effects=[{"kind": "bending", "stiffness": 1.0}])
    assert "bending" in why_fixed(bent)
    row = np.where(np.arange(20) == 3, 0.0, 4.0)
    assert Running.of(bent.build(), row).model.lattice.spring_count == 20


@given(
    old=st.tuples(st.integers(1, 4), st.integers(1, 4)),
    new=st.tuples(st.integers(1, 6), st.integers(1, 6)),
    spacing=st.sampled_from([1.0, 0.5, [0.5, 2.0]]),
    data=st.data(),
)
def test_totals_and_moments_stay(old, new, spacing, data):
    node = data.draw(st.integers(0, (old[0] + 1) * (old[1] + 1) - 1))
    force = [0.3, -0.2]
    pushes = [
        {"on": "right", "force": [0.1, 0.2]},
        {"on": ["top", "bottom"], "total": [0.5, 0.0]},
        {"on": node, "force": force},
    ]
    one = scene(
        lattice={"grid": [old[0] + 1, old[1] + 1], "spacing": spacing},
        encoding={"kind": "homogeneous", "upper": 10.0},
        load_cases={"train": [{"name": "all", "hold": "left", "push": pushes}]},
    )
    other = resampled(one, new)
    before, after = one.lattice.build(), other.lattice.build()
    np.testing.assert_allclose(np.ptp(before.nodes, axis=0), np.ptp(after.nodes, axis=0))
    loads = [each.load_cases.build(lattice)[0].forces for each, lattice in ((one, before), (other, after))]
    np.testing.assert_allclose(loads[0].sum(axis=0), loads[1].sum(axis=0), atol=1e-12)
    # A side's own load has its moment whatever the number of nodes; so has a node's, shared by the corners around.
    moments = [
        lattice.nodes[:, 0] @ load[:, 1] - lattice.nodes[:, 1] @ load[:, 0]
        for lattice, load in zip((before, after), loads, strict=True)
    ]
    np.testing.assert_allclose(moments[0], moments[1], atol=1e-12)


def test_named_nodes_are_those_in_the_same_place():
    tables = {"train": [{"name": "held", "hold": ["left", 2], "push": {"on": 8, "force": [1.0, 0.0]}}]}
    finer = resampled(scene(load_cases=tables), (4, 6))
    case = finer.load_cases.train[0]
    lattice = finer.lattice.build()
    assert case.hold[0].on == ["left", 4]
    np.testing.assert_allclose(lattice.nodes[4], [2.0, 0.0])
    np.testing.assert_allclose(lattice.nodes[case.push[0].on[0]], [2.0, 2.0])


def test_a_node_that_is_held_and_gone_is_told():
    tables = {"train": [{"name": "held", "hold": ["left", 1], "push": {"on": 8, "force": [1.0, 0.0]}}]}
    with pytest.raises(SceneError, match="holds node 1, and a grid of 2 x 2 nodes has none in that place"):
        resampled(scene(load_cases=tables), (1, 1))


def test_bounds_go_with_the_spacing_in_3d():
    cube = scene(
        lattice={"grid": [3, 3, 3]},
        load_cases={"train": [{"name": "pull", "hold": "left", "push": {"on": "right", "force": [0.1, 0.0, 0.0]}}]},
    )
    assert resampled(cube, (4, 4, 4)).encoding.upper == pytest.approx(5.0)
    assert resampled(scene(), (4, 4)).encoding.upper == pytest.approx(10.0)


def test_a_uniform_traction_pulls_a_fine_mesh_evenly():
    lattice = SpringLattice.grid([5, 3])
    np.testing.assert_allclose(traction_shares(lattice, ["right"])[side(lattice, "right")], [0.25, 0.5, 0.25])
    uniform = scene(
        reference=FEM | {"poisson": 0.0},
        load_cases={"train": [PULL]},
    )
    (positions,) = fine_positions(uniform, (4, 4))
    nodes = resampled(with_encoding(uniform, "homogeneous"), (4, 4)).lattice.build().nodes
    np.testing.assert_allclose(positions[:, 0], nodes[:, 0] * (1 + 0.6 / 2 / 10), atol=1e-12)


def test_all_resolutions_learn_the_same_body():
    setup = scene().build()
    varied = {each.name: each.setup for each in resolutions(setup).of if each.series == "resolution, free"}
    assert list(varied) == ["2 x 2 nodes", "3 x 3 nodes", "5 x 5 nodes", "9 x 9 nodes"]
    corners = [each.reference_positions[:, [0, -1]] for each in varied.values()]
    assert all(np.array_equal(corners[0], corner) for corner in corners)


def test_one_mass_on_springs_has_the_period_of_a_pendulum():
    setup = scene(lattice={"grid": [2, 2], "neighbourhood": "von-neumann"}, encoding={"kind": "real", "upper": 9.0},
                  load_cases={"train": [{"name": "held", "hold": [0, 1, 2], "push": {"on": 3, "force": [0.1, 0.1]}}]},
                  effects=[{"kind": "inertia", "mass": 2.0}]).build()  # fmt: skip
    period = slowest_period(setup.model, np.full(4, 8.0), setup.cases[0])
    assert period == pytest.approx(2 * np.pi * np.sqrt(2.0 / 8.0))


def test_a_step_takes_what_a_motion_takes_by_hand():
    setup = scene().build()
    row = np.full(setup.lattice.spring_count, 4.0)
    clock = clockwork(setup.scene, setup.model, row, setup.cases[0])
    body = moving(clock, setup.model, row, setup.cases[0], 1e-8)
    step = time_step(body, 0.2)
    longer = replace(body, steps=step.steps)
    longer.run()
    begun = time.perf_counter()
    motions = longer.run()
    by_hand = (time.perf_counter() - begun) / motions.steps.max()
    assert motions.steps.max() == step.steps
    assert step.seconds.value / 20 < by_hand < 20 * step.seconds.value  # other processes share the machine


def test_a_scene_in_motion_keeps_its_own_step_and_is_fitted_over_its_times():
    moved = scene(
        reference=FEM | {"density": 1.0, "stiffness_damping": 0.1},
        effects=[{"kind": "inertia", "density": 1.0}, {"kind": "damping", "springs": 0.1}],
        stepping={"step": 0.2},
        load_cases={"times": [1.0, 2.0], "train": [PULL], "test": [CORNER]},
    )
    setup = moved.build()
    clock = clockwork(moved, setup.model, np.full(20, 4.0), setup.cases[0])
    assert clock.stepping.step == 0.2
    assert [effect.name for effect in clock.effects] == ["inertia", "damping"]
    (point,) = AXIS.measure(setup, Request(2.0, only=frozenset({("encodings", "two-class")}))).points
    assert np.isfinite(point.errors).all()


def taking(seconds):
    """A step."""
    found = Interval(seconds, seconds, seconds)
    return Step(found, found, 20)


class ByFormula(Sizes):
    """Times that are known: so many microseconds a node."""

    def measure(self, count, seconds):
        cells = tuple(self.cells(count).tolist())
        return Size(cells, count, taking(1e-5 * (count + 1) ** 2))


def test_the_largest_that_keeps_a_rate_is_found_between_its_neighbours():
    sizes = ByFormula(stage(scene()), homogeneous=None, clock=None)
    kept = largest_that_keeps("1 kHz", sizes, 100.0)
    assert kept.is_largest
    assert kept.numbers()["nodes"] == [10, 10]
    assert kept.sentence == "1 kHz is kept by at most 10 x 10 nodes (9 springs), 1 ms a step."
    assert "at least" in largest_that_keeps("60 Hz", sizes, 0.0).sentence


def test_a_rate_that_nothing_keeps_is_told():
    class Slow(ByFormula):
        def measure(self, count, seconds):
            return replace(super().measure(count, seconds), step=taking(1.0))

    kept = largest_that_keeps("1 kHz", Slow(stage(scene()), homogeneous=None, clock=None), 1000.0)
    assert kept.largest is None
    assert "kept by no lattice" in kept.sentence


def test_no_error_is_below_what_the_forward_solve_can_tell():
    setup = scene(reference=classes_reference()).build()
    result = AXIS.measure(setup, Request(4.0, only=frozenset({("encodings", "two-class")})))
    assert result.points[0].error.value == setup.objective.tolerance
    assert any(note.startswith("Errors are not below 1e-08") for note in result.notes)


def test_a_setting_can_be_asked_for_alone():
    request = Request(1.0, only=frozenset({("neighbourhood", "moore")}))
    assert [point.name for point in AXIS.measure(scene().build(), request).points] == ["moore"]


def test_a_variation_that_is_the_scene_itself_keeps_its_reference():
    setup = scene().build()
    assert on_same_nodes(setup, with_encoding(setup.scene, "two-class")).objective.reference is not None
    assert findings.why_missing(setup.scene) is None
