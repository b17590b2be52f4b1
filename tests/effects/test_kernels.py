"""Every kernel by itself: forces are those of the energy, blocks those of the forces, parameters those of both."""

import subprocess
import sys

import numpy as np
import pytest
from catalogue import BODIES, POTENTIALS

import springopt as so
from springopt.effects.probe import force_derivatives, forces_of, probe, times_blocks

every_effect = pytest.mark.parametrize("name", POTENTIALS)
every_body = pytest.mark.parametrize("where", BODIES)


def differences(function, point, direction, step):
    """The derivative of a function along a direction: central differences of two steps, extrapolated."""

    def central(h):
        return (function(point + h * direction) - function(point - h * direction)) / (2 * h)

    return (4.0 * central(step / 2) - central(step)) / 3.0


def prepared(name, where):
    lattice = BODIES[where]
    make, fitted = POTENTIALS[name]
    effect = make(lattice)
    values = np.concatenate([np.zeros(0), *effect.parameters(lattice).values()])
    stiffness = np.random.default_rng(3).uniform(1.0, 5.0, lattice.spring_count)
    return lattice, effect, effect.potential(lattice, frozenset(fitted)), stiffness, values


@every_body
@every_effect
def test_forces_are_those_of_the_energy_and_blocks_those_of_the_forces(name, where):
    lattice, _, kernel, stiffness, values = prepared(name, where)
    rng = np.random.default_rng(4)
    for size in (0.02, 0.2):
        u, direction = rng.standard_normal((2, lattice.nodes.size)) * [[size], [1.0]]

        def at(u):
            return probe(kernel, lattice, u[None], stiffness=stiffness, values=values)

        here = at(u)
        expected = differences(lambda u: at(u).energy[0], u, direction, 1e-4)
        assert here.forces[0] @ direction == pytest.approx(expected, rel=1e-7, abs=1e-9)
        expected = differences(lambda u: at(u).forces[0], u, direction, 1e-4)
        product = times_blocks(kernel, here.blocks, direction[None], lattice.dimension)[0]
        np.testing.assert_allclose(product, expected, atol=1e-7 * np.abs(expected).max())


@every_body
@every_effect
def test_forces_change_with_the_parameters_as_is_said(name, where):
    lattice, effect, kernel, stiffness, values = prepared(name, where)
    rng = np.random.default_rng(5)
    u, direction = 0.1 * rng.standard_normal(lattice.nodes.size), rng.standard_normal(len(values))
    options = {"stiffness": stiffness, "is_linear": False}
    expected = differences(
        lambda values: forces_of(kernel, lattice, u[None], values=values, **options)[0], values, direction, 1e-3
    )
    found = direction @ force_derivatives(effect, kernel, lattice, u, values=values, **options)
    np.testing.assert_allclose(found, expected, atol=1e-9 * max(np.abs(expected).max(), 1e-3))


@every_body
@pytest.mark.parametrize("name", [name for name in POTENTIALS if "plane" not in name and "sphere" not in name])
def test_a_rigid_motion_costs_nothing_more(name, where):
    lattice, _, kernel, stiffness, values = prepared(name, where)
    rng = np.random.default_rng(6)
    turn, _ = np.linalg.qr(rng.standard_normal((lattice.dimension, lattice.dimension)))
    turn[:, 0] *= np.sign(np.linalg.det(turn))
    u = 0.1 * rng.standard_normal(lattice.nodes.shape)
    moved = (lattice.nodes + u) @ turn.T + 3.0 - lattice.nodes
    states = np.stack([u, moved]).reshape(2, -1)
    before, after = (probe(kernel, lattice, row[None], stiffness=stiffness, values=values) for row in states)
    np.testing.assert_allclose(after.energy, before.energy, rtol=1e-12)
    turned = before.forces.reshape(lattice.nodes.shape) @ turn.T
    np.testing.assert_allclose(after.forces.reshape(lattice.nodes.shape), turned, atol=1e-12 * np.abs(turned).max())


@every_body
@pytest.mark.parametrize("name", POTENTIALS)
def test_eight_states_are_eight_times_one(name, where):
    lattice, _, kernel, stiffness, values = prepared(name, where)
    rng = np.random.default_rng(7)
    states = rng.standard_normal((10, lattice.nodes.size)) * np.logspace(-3, 1, 10)[:, None]
    together = probe(kernel, lattice, states, stiffness=stiffness, values=values)
    for number, u in enumerate(states):
        alone = probe(kernel, lattice, u[None], stiffness=stiffness, values=values)
        np.testing.assert_array_equal(alone.forces[0], together.forces[number])
        np.testing.assert_array_equal(alone.blocks[0], together.blocks[number])
    assert np.isfinite(together.forces).all()
    assert np.isfinite(together.blocks).all()


@every_body
@pytest.mark.parametrize("name", POTENTIALS)
def test_all_nodes_at_one_place_give_numbers(name, where):
    lattice, _, kernel, stiffness, values = prepared(name, where)
    u = (lattice.nodes[4] - lattice.nodes).ravel()
    for answer in probe(kernel, lattice, u[None], stiffness=stiffness, values=values).lanes:
        assert np.isfinite(answer).all()


def test_effects_that_are_not_named_are_not_compiled():
    code = "import sys, springopt as so; so.Volume(1.0); print(*(m for m in sys.modules if m.endswith('_kernel')))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert not done.stdout.split()


def test_effects_are_told_apart_by_their_names():
    public = (getattr(so, name) for name in so.__all__ if isinstance(getattr(so, name), type))
    names = [kind.name for kind in public if hasattr(kind, "scales_with_stiffness") and kind.name]
    assert len(set(names)) == len(names)


def test_a_kernel_reads_the_nodes_of_a_grid_row_by_row():
    grid = so.SpringLattice.grid((4, 3))
    kernel = so.Bending(1.0).potential(grid)
    answer = probe(
        kernel, grid, np.zeros((1, grid.nodes.size)), stiffness=np.ones(grid.spring_count), values=np.ones(1)
    )
    assert answer.energy[0] == 0
    np.testing.assert_array_equal(answer.forces, 0)
