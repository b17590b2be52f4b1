"""Forces and tangents against differences, and patches: what an affine motion must do to every kind of element."""

import numpy as np
import pytest

from springopt.lattice import SpringLattice
from springopt.load_case import LoadCase
from springopt.nodal_volumes import nodal_volumes
from springopt.reference.fem import FemReference

SHAPES = {"triangle": (4, 3), "quad": (4, 3), "tetra": (3, 3, 3), "hexahedron": (3, 3, 3)}
LAWS = ["saint-venant-kirchhoff", "neo-hookean"]
FORMULATIONS = [
    *((cell, plane, "standard") for cell in ("triangle", "quad") for plane in ("stress", "strain")),
    *((cell, "strain", "standard") for cell in ("tetra", "hexahedron")),
    *((cell, "strain", "b-bar") for cell in ("quad", "hexahedron")),
]
every_law = pytest.mark.parametrize("law", LAWS)
every_formulation = pytest.mark.parametrize(("cell", "plane", "formulation"), FORMULATIONS)


def uneven(cell, share):
    """A grid whose nodes inside are moved at random by a share of the spacing, and which nodes are outside."""
    lattice = SpringLattice.grid([count + 1 for count in SHAPES[cell]] if share else SHAPES[cell], cell=cell)
    nodes = lattice.nodes.copy()
    outside = np.any((nodes == nodes.min(axis=0)) | (nodes == nodes.max(axis=0)), axis=1)
    nodes[~outside] += np.random.default_rng(0).uniform(-share, share, nodes[~outside].shape)
    return (nodes, lattice.cells, cell), outside


def differences(function, point, direction, step=1e-2):
    """The derivative along a direction: central differences of three steps, extrapolated."""

    def central(h):
        return (function(point + h * direction) - function(point - h * direction)) / (2 * h)

    coarse, middle, fine = (central(step / 2**k) for k in range(3))
    return (64 * fine - 20 * middle + coarse) / 45


@every_law
@every_formulation
def test_forces_are_the_derivative_of_energy_and_the_tangent_that_of_forces(law, cell, plane, formulation):
    mesh, _ = uneven(cell, 0.2)
    body = FemReference(mesh, young=2.0, poisson=0.3, plane=plane, law=law, formulation=formulation, thickness=0.7).body
    rng = np.random.default_rng(1)
    u, direction = rng.uniform(-0.08, 0.08, mesh[0].shape), rng.uniform(-1, 1, mesh[0].shape)
    assert body.is_admissible(u)
    work, slope = np.sum(body.internal_forces(u) * direction), differences(body.energy, u, direction)
    assert work == pytest.approx(slope, rel=1e-8)
    stiff = (body.tangent(u) @ direction.ravel()).reshape(u.shape)
    expected = differences(body.internal_forces, u, direction)
    np.testing.assert_allclose(stiff, expected, atol=1e-8 * np.abs(expected).max())
    tangent = body.tangent(u)
    assert abs(tangent - tangent.T).max() < 1e-13 * abs(tangent).max()


@pytest.mark.parametrize("law", ["linear", *LAWS])
@every_formulation
def test_an_affine_motion_of_the_outside_moves_the_inside_alike(law, cell, plane, formulation):
    mesh, outside = uneven(cell, 0.15)
    nodes = mesh[0]
    d = nodes.shape[1]
    gradient = np.random.default_rng(2).uniform(-0.25, 0.25, (d, d)) + 0.1 * np.eye(d)
    displacements = nodes @ gradient.T
    case = LoadCase("moved", outside, np.zeros(nodes.shape), np.where(outside[:, None], displacements, np.nan))
    reference = FemReference(mesh, young=7.0, poisson=0.3, plane=plane, law=law, formulation=formulation)
    assert (~outside).any()
    np.testing.assert_allclose(reference.deform(case), nodes + displacements, atol=1e-10)


@every_law
@every_formulation
def test_a_turned_body_is_without_force(law, cell, plane, formulation):
    mesh, _ = uneven(cell, 0.1)
    d = mesh[0].shape[1]
    body = FemReference(mesh, young=2.0, poisson=0.3, plane=plane, law=law, formulation=formulation).body
    rotation = np.eye(d)
    rotation[:2, :2] = [[0.0, -1.0], [1.0, 0.0]]
    turned = mesh[0] @ rotation.T - mesh[0]
    np.testing.assert_allclose(body.internal_forces(turned), 0.0, atol=1e-13)


@every_law
@every_formulation
def test_laws_agree_with_the_linear_one_under_small_loads(law, cell, plane, formulation):
    mesh, _ = uneven(cell, 0.1)
    nodes = mesh[0]
    load = 1e-7 * np.random.default_rng(3).normal(size=nodes.shape)
    case = LoadCase("small", nodes[:, 0] == 0.0, load)
    linear, large = (
        FemReference(mesh, young=2.0, poisson=0.3, plane=plane, law=name, formulation=formulation).deform(case) - nodes
        for name in ("linear", law)
    )
    # What is left is of second order in the strain.
    assert np.abs(large - linear).max() < 1e-5 * np.abs(linear).max()


@every_formulation
def test_errors_fall_with_the_square_of_the_cell_size(cell, plane, formulation):
    """Displacements a sin(pi x) sin(pi y) ..., by the body force that they need, in a cube that is held outside."""
    coarse, fine = (manufactured_error(cell, plane, formulation, count) for count in (6, 12))
    assert 3.3 < coarse / fine < 5.0


def manufactured_error(cell, plane, formulation, count):
    d = len(SHAPES[cell])
    lattice = SpringLattice.grid([count + 1] * d, spacing=1 / count, neighbourhood="von-neumann", cell=cell)
    reference = FemReference(lattice, young=1.0, poisson=0.3, plane=plane, formulation=formulation)
    nodes, a = lattice.nodes, np.arange(1.0, d + 1)
    sines, cosines = np.sin(np.pi * nodes), np.cos(np.pi * nodes)
    product = sines.prod(axis=1)
    second = np.empty((len(nodes), d, d))  # of the product of sines, by pi^2
    for i in range(d):
        for j in range(d):
            factors = np.where(np.isin(np.arange(d), [i, j]), cosines, sines)
            second[:, i, j] = -product if i == j else factors.prod(axis=1)
    material = reference._material
    stress_slope = material.shear * -d * product[:, None] * a + (material.lame + material.shear) * second @ a
    forces = -(np.pi**2) * stress_slope * nodal_volumes(nodes, lattice.cells, cell)[:, None]
    outside = np.any((nodes < 1e-9) | (nodes > 1 - 1e-9), axis=1)
    displacements = reference.deform(LoadCase("manufactured", outside, forces)) - nodes
    return np.sqrt(np.mean((displacements - product[:, None] * a) ** 2))
