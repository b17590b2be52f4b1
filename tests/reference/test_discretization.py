"""Shape gradients, weights and masses of uneven cells, against integrals that are known."""

import numpy as np
import pytest

from springopt.lattice import SpringLattice
from springopt.nodal_volumes import nodal_volumes
from springopt.reference.discretization import discretize, mass_matrix

SHAPES = {"triangle": (5, 4), "quad": (5, 4), "tetra": (4, 3, 3), "hexahedron": (4, 4, 3)}
every_cell = pytest.mark.parametrize("cell", SHAPES)


def uneven(cell):
    """A box from the origin whose nodes inside are moved at random, and its extent."""
    lattice = SpringLattice.grid(SHAPES[cell], cell=cell)
    nodes, extent = lattice.nodes.copy(), np.array(SHAPES[cell]) - 1.0
    inside = np.all((nodes > 0) & (nodes < extent), axis=1)
    assert inside.any()
    nodes[inside] += np.random.default_rng(0).uniform(-0.2, 0.2, nodes[inside].shape)
    return (nodes, lattice.cells, cell), extent


@every_cell
def test_gradients_are_exact_for_linear_functions_and_weights_sum_to_the_volume(cell):
    mesh, extent = uneven(cell)
    found = discretize(*mesh)
    slopes = np.einsum("cqvd,cve->cqed", found.gradients, mesh[0][found.cells])
    np.testing.assert_allclose(slopes, np.broadcast_to(np.eye(len(extent)), slopes.shape), atol=1e-13)
    assert found.weights.sum() == pytest.approx(extent.prod(), rel=1e-13)


@every_cell
def test_cells_keep_their_nodes(cell):
    mesh, _ = uneven(cell)
    np.testing.assert_array_equal(np.sort(discretize(*mesh).cells, axis=1), np.sort(mesh[1], axis=1))


@every_cell
def test_the_rows_of_the_mass_matrix_sum_to_the_nodal_volumes(cell):
    mesh, _ = uneven(cell)
    np.testing.assert_allclose(mass_matrix(*mesh) @ np.ones(len(mesh[0])), nodal_volumes(*mesh), rtol=1e-12)


@every_cell
def test_the_mass_matrix_is_exact_for_linear_velocities(cell):
    """x_i M_ij x_j is the integral of x^2, a third of the volume times the squared length."""
    mesh, extent = uneven(cell)
    x = mesh[0][:, 0]
    assert x @ mass_matrix(*mesh) @ x == pytest.approx(extent.prod() * extent[0] ** 2 / 3, rel=1e-12)
