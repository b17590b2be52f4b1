"""Forces, tangents and energies written anew: by differences, and beside the forward solve's."""

import numpy as np
import pytest

import springopt as so
from springopt.tradeoff.independent.springs import Springs
from springopt.tradeoff.independent.system import System

EFFECTS = [so.Volume(2.0), so.Stiffening(cubic=2.0), so.Bending(0.3), so.Gravity((0.1, -0.2)), so.Prestress(0.9)]


@pytest.fixture
def system():
    grid = so.SpringLattice.grid((3, 3))
    stiffness = np.random.default_rng(0).uniform(1.0, 5.0, grid.spring_count)
    return System.of(so.Model(grid, [*EFFECTS, so.Damping(springs=0.2, nodes=0.1), so.Inertia(mass=2.0)]), stiffness)


@pytest.fixture
def u(system):
    return np.random.default_rng(1).normal(scale=0.1, size=system.lattice.nodes.shape)


def test_forces_are_the_slope_of_the_energy_and_the_tangent_that_of_the_forces(system, u):
    direction = np.random.default_rng(2).normal(size=u.shape)
    h = 1e-5
    slope = (system.energy(u + h * direction) - system.energy(u - h * direction)) / (2 * h)
    assert slope == pytest.approx(float(np.vdot(system.forces(u), direction)), rel=1e-8)
    change = (system.forces(u + h * direction) - system.forces(u - h * direction)) / (2 * h)
    np.testing.assert_allclose(
        system.tangent(u) @ direction.ravel(), change.ravel().astype(float), rtol=1e-7, atol=1e-8
    )


def test_the_drag_is_linear_in_the_velocity(system, u):
    v = np.random.default_rng(3).normal(size=u.shape)
    np.testing.assert_allclose(system.damping(u) @ v.ravel(), system.drag(u, v).ravel(), atol=1e-12)
    assert system.masses.tolist() == [2.0] * 9
    np.testing.assert_allclose(system.loads, np.tile([0.1, -0.2], (9, 1)))


def test_displacements_beyond_double_precision_reach_the_forces(system):
    u = np.random.default_rng(1).uniform(0.1, 0.2, system.lattice.nodes.shape).astype(np.longdouble)
    beyond = np.random.default_rng(2).uniform(-3e-18, 3e-18, u.shape)
    by_tangent = (system.tangent(u) @ beyond.ravel()).reshape(u.shape)
    change = system.forces(u + beyond) - system.forces(u)
    np.testing.assert_allclose(change.astype(float), by_tangent, atol=3e-18)
    assert np.abs(by_tangent).max() > 2e-17


def test_springs_without_a_length_pull_with_k_times_their_vector():
    pair = so.SpringLattice(np.zeros((2, 2)), np.array([[0, 1]]), rest_lengths=np.zeros(1))
    springs = Springs.of(pair, np.array([3.0]))
    u = np.array([[0.0, 0.0], [0.3, 0.4]], dtype=np.longdouble)
    np.testing.assert_allclose(springs.forces(u)[1].astype(float), [0.9, 1.2])
    np.testing.assert_allclose(springs.forces(0 * u).astype(float), 0.0)
    np.testing.assert_allclose(springs.blocks(u)[0].astype(float), 3.0 * np.eye(2), atol=1e-15)
    assert springs.energy(u) == pytest.approx(3.0 * 0.25 / 2)
