import numpy as np
import pytest

from springopt.lattice import SpringLattice
from springopt.reference.rigid_modes import RigidModes

#: Two squares that share node 2 only: a hinge.
HINGE = (
    np.array([[0, 0], [1, 0], [1, 1], [0, 1], [2, 1], [2, 2], [1, 2]], float),
    np.array([[0, 1, 2, 3], [2, 4, 5, 6]]),
)


def held(node_count, *nodes):
    return np.repeat(np.isin(np.arange(node_count), nodes)[:, None], 2, axis=1)


@pytest.mark.parametrize(("shape", "count"), [((3, 3), 3), ((3, 3, 3), 6)])
@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e9])
def test_a_body_without_supports_has_all_rigid_modes_in_any_unit(shape, count, scale):
    grid = SpringLattice.grid(shape, spacing=scale)
    modes = RigidModes(grid.nodes + 5 * scale, grid.cells, grid.cell_type)
    assert modes.count_free(np.zeros(grid.nodes.shape, bool)) == count


def test_three_degrees_of_freedom_hold_a_plane_body_unless_they_point_to_one_center():
    grid = SpringLattice.grid((3, 3))
    modes = RigidModes(grid.nodes, grid.cells, grid.cell_type)
    supports = np.zeros((9, 2), bool)
    supports[0], supports[2, 1] = True, True
    assert modes.count_free(supports) == 0
    supports[2] = [True, False]
    assert modes.count_free(supports) == 1


def test_nodes_on_a_line_leave_a_rotation_about_it():
    grid = SpringLattice.grid((3, 3, 3))
    supports = np.zeros((27, 3), bool)
    supports[:3] = True
    assert RigidModes(grid.nodes, grid.cells, grid.cell_type).count_free(supports) == 1


def test_a_hinge_leaves_its_other_side_free_to_turn():
    modes = RigidModes(*HINGE, "quad")
    assert modes.count_free(held(7)) == 4
    assert modes.count_free(held(7, 0, 1)) == 1
    assert modes.count_free(held(7, 0, 1, 5)) == 0


def test_a_second_body_that_nothing_holds_is_free():
    square = SpringLattice.grid((2, 2))
    nodes = np.concatenate([square.nodes, square.nodes + 5.0])
    cells = np.concatenate([square.cells, square.cells + 4])
    assert RigidModes(nodes, cells, "quad").count_free(held(8, 0, 1)) == 3
