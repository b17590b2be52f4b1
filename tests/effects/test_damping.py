"""Dashpots and drag."""

import numpy as np
import pytest
from catalogue import BODIES

import springopt as so
from springopt.effects.probe import probe, times_blocks

every_body = pytest.mark.parametrize("where", BODIES)


def damped(where, velocities, springs=0.3, nodes=0.5, displacements=None):
    """(the lattice, the kernel, what it adds) at these velocities."""
    lattice = BODIES[where]
    effect = so.Damping(springs=springs, nodes=nodes)
    kernel, parameters = effect.dissipation(lattice), effect.parameters(lattice)
    u = np.zeros(lattice.nodes.size) if displacements is None else displacements
    stiffness = np.random.default_rng(1).uniform(1.0, 5.0, lattice.spring_count)
    options = {"stiffness": stiffness, "values": np.concatenate(list(parameters.values()))}
    return lattice, kernel, probe(kernel, lattice, u[None], velocities=velocities.reshape(1, -1), **options)


@every_body
def test_forces_are_linear_in_the_velocity_and_take_power(where):
    rng = np.random.default_rng(2)
    u, v = 0.2 * rng.standard_normal((2, BODIES[where].nodes.size))
    drag = rng.uniform(0.1, 1.0, BODIES[where].node_count)
    lattice, kernel, found = damped(where, v, nodes=drag, displacements=u)
    product = times_blocks(kernel, found.blocks, v[None], lattice.dimension)
    np.testing.assert_allclose(product, found.forces, atol=1e-13)
    assert found.energy[0] == pytest.approx(v @ found.forces[0], rel=1e-12)
    columns = [times_blocks(kernel, found.blocks, unit[None], lattice.dimension)[0] for unit in np.eye(len(v))]
    np.testing.assert_allclose(columns, np.transpose(columns), atol=1e-13)
    assert np.linalg.eigvalsh(columns)[0] > 0


@every_body
def test_dashpots_feel_no_rigid_motion(where):
    lattice = BODIES[where]
    spin = np.random.default_rng(3).standard_normal((lattice.dimension, lattice.dimension))
    velocities = lattice.nodes @ (spin - spin.T) + 0.7
    _, _, found = damped(where, velocities, nodes=0.0)
    np.testing.assert_allclose(found.forces, 0.0, atol=1e-13)
    _, _, found = damped(where, np.ones(lattice.nodes.shape), springs=0.0)
    np.testing.assert_allclose(found.forces, 0.5, atol=1e-15)


def test_a_dashpot_resists_along_its_spring_where_that_is_now():
    lattice = so.SpringLattice([[0, 0], [1, 0]], [[0, 1]])
    kernel = so.Damping(springs=2.0).dissipation(lattice)
    turned = np.array([[0.0, 0.0, -1.0, 3.0]])
    options = {"stiffness": np.array([5.0]), "values": np.array([2.0, 0.0])}
    found = probe(kernel, lattice, turned, velocities=np.array([[0.0, 0.0, 1.0, 1.0]]), **options)
    np.testing.assert_allclose(found.forces[0], [0, -10, 0, 10], atol=1e-14)
    assert found.energy[0] == pytest.approx(10.0)
    gone = probe(kernel, lattice, np.array([[0, 0, -1.0, 0]]), velocities=np.ones((1, 4)), **options)
    np.testing.assert_array_equal(gone.forces, 0)


def test_nothing_of_it_is_felt_at_rest():
    grid = so.SpringLattice.grid((4, 3))
    case = so.LoadCase("pull", so.side(grid, "left"), np.full(grid.nodes.shape, 0.01))
    known, found = (so.Model(grid, effects).solve(np.full(29, 3.0), [case]) for effects in ([], so.Damping(1.0, 2.0)))
    np.testing.assert_array_equal(found.positions, known.positions)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"springs": -1.0}, "springs is -1, but it must be finite and not negative"),
        ({"nodes": [1.0, 2.0]}, r"nodes must have the shape \(12,\), not \(2,\)"),
    ],
)
def test_options_that_do_not_fit_are_refused(options, message):
    with pytest.raises(so.UserError, match=message):
        so.Model(so.SpringLattice.grid((4, 3)), so.Damping(**options))
