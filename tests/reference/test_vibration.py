"""Linear bodies in motion: oscillators, decay, energy, free flight, and what is refused."""

import numpy as np
import pytest

from springopt.effects.gravity import Gravity
from springopt.errors import UserError
from springopt.lattice import SpringLattice, side
from springopt.load_case import LoadCase
from springopt.nodal_volumes import nodal_volumes
from springopt.reference import vibration
from springopt.reference.fem import FemReference

SHAPES = {"triangle": (4, 3), "quad": (4, 3), "tetra": (3, 3, 2), "hexahedron": (3, 3, 2)}
every_cell = pytest.mark.parametrize(("cell", "shape"), SHAPES.items())
every_mass = pytest.mark.parametrize("lumped", [False, True], ids=["consistent", "lumped"])


def body(lattice, **options):
    return FemReference(lattice, **{"young": 7.0, "poisson": 0.3, "density": 2.0} | options)


def pulled(lattice, times, **changes):
    forces = np.random.default_rng(0).normal(size=lattice.nodes.shape)
    return LoadCase(**{"name": "case", "supports": side(lattice, "left"), "forces": forces, "times": times} | changes)


@every_mass
@pytest.mark.parametrize("thickness", [1.0, 0.3])
def test_one_element_swings_at_its_frequency(lumped, thickness):
    """A bar of one element that moves lengthwise: K = E A / L, its mass rho A L / 2 lumped and rho A L / 3 else."""
    lattice = SpringLattice.grid((2, 2), spacing=(0.5, 1.0))
    right = side(lattice, "right")
    supports = np.stack([~right, np.ones(4, bool)], axis=1)
    times = np.linspace(0.05, 3.0, 40)
    case = LoadCase("pulled", supports, np.where(right[:, None], [0.1, 0.0], 0.0), times=times)
    reference = body(lattice, poisson=0.0, lumped=lumped, thickness=thickness)
    stiffness, mass = 7.0 * thickness / 0.5, 2.0 * thickness * 0.5 / (2 if lumped else 3)
    motion = 0.2 / stiffness * (1 - np.cos(np.sqrt(stiffness / mass) * times))
    found = reference.deform(case) - lattice.nodes
    np.testing.assert_allclose(found[:, right, 0], np.repeat(motion[:, None], 2, axis=1), atol=1e-13)
    np.testing.assert_array_equal(found[:, ~right], 0.0)


@every_mass
def test_rayleigh_damping_decays_as_it_should(lumped):
    """Peaks of the oscillator above fall by exp(-damping / 2 * period), damping = a + b omega^2."""
    lattice = SpringLattice.grid((2, 2))
    right = side(lattice, "right")
    supports = np.stack([~right, np.ones(4, bool)], axis=1)
    damping = 0.11 + 0.02 * (square := 7.0 / (2.0 / (2 if lumped else 3)))
    period = 2 * np.pi / np.sqrt(square - damping**2 / 4)
    case = LoadCase("pulled", supports, np.where(right[:, None], [0.1, 0.0], 0.0), times=period * np.arange(1, 5))
    reference = body(lattice, poisson=0.0, lumped=lumped, mass_damping=0.11, stiffness_damping=0.02)
    distances = 0.2 / 7.0 - (reference.deform(case) - lattice.nodes)[:, right, 0].mean(axis=1)
    np.testing.assert_allclose(distances[1:] / distances[:-1], np.exp(-damping / 2 * period), rtol=1e-10)


@every_cell
@every_mass
def test_energy_is_constant_without_damping(cell, shape, lumped):
    lattice = SpringLattice.grid(shape, cell=cell)
    reference = body(lattice, lumped=lumped)
    step = 1e-4
    times = np.array([0.3, 1.1, 5.0])
    around = np.sort(np.concatenate([times - 2 * step, times - step, times, times + step, times + 2 * step]))
    case = pulled(lattice, around)
    u = (reference.deform(case) - lattice.nodes).reshape(3, 5, -1)
    speed = (8 * (u[:, 3] - u[:, 1]) - u[:, 4] + u[:, 0]) / (12 * step)
    kinetic = np.einsum("tx,tx->t", speed, (reference._vibration.mass @ speed.T).T) / 2
    strain = np.einsum("tx,tx->t", u[:, 2], (reference.stiffness_matrix @ u[:, 2].T).T) / 2
    np.testing.assert_allclose(kinetic + strain - u[:, 2] @ case.forces.ravel(), 0.0, atol=1e-8 * kinetic.max())


@every_cell
@every_mass
@pytest.mark.parametrize("mass_damping", [0.0, 0.7])
def test_without_supports_the_center_of_mass_flies_freely(cell, shape, lumped, mass_damping):
    lattice = SpringLattice.grid(shape, cell=cell)
    volumes = nodal_volumes(lattice.nodes, lattice.cells, cell)
    times, mass = np.array([0.01, 1.0, 20.0]), 2.0 * volumes.sum()
    gravity = Gravity((0.0, -9.81, 0.4)[: len(shape)], mass=2.0 * volumes)
    case = pulled(lattice, times, supports=np.zeros(lattice.node_count, bool))
    reference = body(lattice, lumped=lumped, mass_damping=mass_damping, effects=[gravity])
    center = np.einsum("n,tnd->td", volumes, reference.deform(case) - lattice.nodes) / volumes.sum()
    acceleration = case.forces.sum(axis=0) / mass + gravity.acceleration
    c = mass_damping
    course = (c * times - 1 + np.exp(-c * times)) / c**2 if c else times**2 / 2
    np.testing.assert_allclose(center, course[:, None] * acceleration, rtol=1e-9, atol=1e-12)


@every_cell
@every_mass
def test_a_falling_body_does_not_deform(cell, shape, lumped):
    lattice = SpringLattice.grid(shape, cell=cell)
    gravity = Gravity((0.0, -9.81, 0.0)[: len(shape)], mass=2.0 * nodal_volumes(lattice.nodes, lattice.cells, cell))
    case = LoadCase("falling", np.zeros(lattice.node_count, bool), np.zeros(lattice.nodes.shape), times=[0.5, 2.0])
    fallen = body(lattice, lumped=lumped, effects=[gravity]).deform(case) - lattice.nodes
    np.testing.assert_allclose(
        fallen[..., 1], -9.81 / 2 * np.array([[0.25], [4.0]]) * np.ones(lattice.node_count), atol=1e-9
    )


@every_mass
@pytest.mark.parametrize("formulation", ["standard", "b-bar"])
def test_with_damping_a_motion_ends_in_the_static_answer(lumped, formulation):
    lattice = SpringLattice.grid((4, 3))
    reference = body(
        lattice, plane="strain", formulation=formulation, lumped=lumped, mass_damping=0.5, stiffness_damping=0.1
    )
    right = side(lattice, "right")
    prescribed = np.where(right[:, None], [0.1, np.nan], np.nan)
    prescribed[side(lattice, "left")] = 0.0
    case = pulled(lattice, [1e3], prescribed=prescribed)
    still = LoadCase("case", case.supports, case.forces, case.prescribed)
    np.testing.assert_allclose(reference.deform(case)[0], reference.deform(still), atol=1e-12)


def test_without_damping_the_static_answer_is_the_mean_over_time():
    lattice = SpringLattice.grid((4, 3))
    case = pulled(lattice, np.linspace(0.0, 2e3, 20_001)[1:])
    reference = body(lattice)
    static = reference.deform(pulled(lattice, None)) - lattice.nodes
    mean = reference.deform(case).mean(axis=0) - lattice.nodes
    assert np.linalg.norm(mean - static) < 2e-3 * np.linalg.norm(static)


def test_supports_are_where_they_are_prescribed_from_the_first_moment_and_the_rest_starts_at_rest():
    lattice = SpringLattice.grid((4, 3))
    left = side(lattice, "left")
    case = pulled(lattice, [1e-6], forces=np.zeros((12, 2)), prescribed=np.where(left[:, None], [0.3, -0.1], np.nan))
    moved = body(lattice).deform(case)[0] - lattice.nodes
    np.testing.assert_allclose(moved[left], np.broadcast_to([0.3, -0.1], (3, 2)), rtol=1e-14)
    np.testing.assert_allclose(moved[~left], 0.0, atol=1e-10)


def test_a_body_held_everywhere_stays_where_it_is_put():
    lattice = SpringLattice.grid((2, 2))
    case = LoadCase("held", np.ones(4, bool), np.ones((4, 2)), 0.1 * np.ones((4, 2)), times=[1.0, 2.0])
    np.testing.assert_array_equal(body(lattice).deform(case), np.stack([lattice.nodes + 0.1] * 2))


def test_thickness_changes_neither_frequencies_nor_shapes():
    lattice = SpringLattice.grid((4, 3))
    case = pulled(lattice, [0.7])
    thin = LoadCase("case", case.supports, 0.2 * case.forces, times=case.times)
    np.testing.assert_allclose(body(lattice, thickness=0.2).deform(thin), body(lattice).deform(case), rtol=1e-10)


def test_density_missing_is_refused():
    lattice = SpringLattice.grid((3, 3))
    with pytest.raises(UserError, match="needs a body with mass; give the finite element reference a density"):
        body(lattice, density=None).deform(pulled(lattice, [1.0]))


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"density": 0.0}, "density is 0, but it must be positive"),
        ({"density": [1.0, 2.0]}, r"density must have the shape \(\)"),
        ({"mass_damping": -1.0}, "mass_damping is -1, but it must be finite and not negative"),
        ({"stiffness_damping": np.nan}, "stiffness_damping is nan"),
    ],
)
def test_impossible_masses_and_dampings_are_refused(changes, sentence):
    with pytest.raises(UserError, match=sentence):
        body(SpringLattice.grid((3, 3)), **changes)


def test_too_many_degrees_of_freedom_are_refused(monkeypatch):
    monkeypatch.setattr(vibration, "MOST", 10)
    lattice = SpringLattice.grid((3, 3))
    with pytest.raises(
        UserError, match="has 12 degrees of freedom, and at most 10 can be solved for; take fewer nodes"
    ):
        body(lattice).deform(pulled(lattice, [1.0]))
