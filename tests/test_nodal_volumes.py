import numpy as np
import pytest

from springopt.lattice import SpringLattice
from springopt.nodal_volumes import nodal_volumes

SHAPES = {"triangle": (4, 3), "quad": (4, 3), "tetra": (3, 4, 2), "hexahedron": (3, 4, 2)}


@pytest.mark.parametrize(("cell", "shape"), SHAPES.items())
def test_all_nodes_together_have_the_volume_of_the_body(cell, shape):
    grid = SpringLattice.grid(shape, cell=cell)
    rng = np.random.default_rng(0)
    inside = np.all((grid.nodes > 0) & (grid.nodes < np.array(shape) - 1), axis=1)
    nodes = grid.nodes + np.where(inside[:, None], rng.uniform(-0.2, 0.2, grid.nodes.shape), 0.0)
    volumes = nodal_volumes(nodes, grid.cells, cell)
    assert volumes.sum() == pytest.approx(np.prod(np.array(shape) - 1.0), rel=1e-14)
    # The moments agree too: the body's centre is the mean of its nodes.
    moved = nodal_volumes(2.0 * nodes, grid.cells, cell)
    np.testing.assert_allclose(moved, 2.0 ** len(shape) * volumes, rtol=1e-13)


def test_corners_of_a_square_have_a_quarter_each_and_of_a_cube_an_eighth():
    np.testing.assert_allclose(nodal_volumes(*_parts((2, 2))), 0.25)
    np.testing.assert_allclose(nodal_volumes(*_parts((2, 2, 2))), 0.125)


def _parts(shape):
    grid = SpringLattice.grid(shape)
    return grid.nodes, grid.cells, grid.cell_type
