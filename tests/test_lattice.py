import numpy as np
import pytest

from springopt.errors import UserError
from springopt.lattice import SpringLattice, side

SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]])


def lattice(**changes):
    return SpringLattice(**({"nodes": SQUARE, "springs": [[0, 1], [0, 3]]} | changes))


def test_rest_lengths_are_the_distances_unless_given():
    np.testing.assert_allclose(lattice().rest_lengths, [1.0, np.sqrt(2.0)])
    assert lattice(rest_lengths=[0.0, 3.0]).rest_lengths.tolist() == [0.0, 3.0]


def test_coincident_nodes_and_doubled_springs_are_legal():
    doubled = SpringLattice(nodes=[[0.0, 0.0], [0.0, 0.0]], springs=[[0, 1], [1, 0], [0, 1]])
    assert doubled.rest_lengths.tolist() == [0.0, 0.0, 0.0]
    assert not doubled.straight.any()


def test_a_lattice_without_springs_is_legal():
    assert lattice(springs=[]).springs.shape == (0, 2)
    assert lattice(springs=np.empty((0, 2), int)).straight.shape == (0,)


def test_a_lattice_keeps_its_own_copy():
    nodes = SQUARE.copy()
    mine = lattice(nodes=nodes)
    nodes[0] = 7.0
    assert mine.nodes[0].tolist() == [0.0, 0.0]


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"nodes": [[0.0, np.nan], [1.0, 0.0]]}, r"nodes\[0, 1\] is nan"),
        ({"nodes": [0.0, 1.0]}, r"nodes must have the shape \(n, d\)"),
        ({"nodes": np.zeros((4, 1))}, r"\(n, 2\) or \(n, 3\)"),
        ({"nodes": np.zeros((0, 2))}, r"\(n, 2\) or \(n, 3\)"),
        ({"springs": [[0.0, 1.0]]}, "springs must hold integers"),
        ({"springs": [[0, 1, 2]]}, r"springs must have the shape \(s, 2\)"),
        ({"springs": [[0, 1], [0, -1]]}, r"springs\[1, 1\] is -1, but the nodes are numbered 0 to 3"),
        ({"springs": [[0, 4]]}, r"springs\[0, 1\] is 4"),
        ({"springs": [[0, 1], [2, 2]]}, r"springs\[1\] joins node 2 to itself"),
        ({"rest_lengths": [1.0]}, r"rest_lengths must have the shape \(2,\)"),
        ({"rest_lengths": [1.0, -1.0]}, r"rest_lengths\[1\] is -1"),
        ({"rest_lengths": [np.inf, 1.0]}, r"rest_lengths\[0\] is inf"),
        ({"cells": [[0, 1, 3, 2]]}, "cells and cell_type belong together"),
        ({"cell_type": "quad"}, "cells and cell_type belong together"),
        ({"cells": [[0, 1, 3, 2]], "cell_type": "quads"}, "Did you mean 'quad'"),
        ({"cells": [[0, 1, 3]], "cell_type": "quad"}, r"cells must have the shape \(c, 4\)"),
        ({"cells": [[0, 1, 3, 4]], "cell_type": "quad"}, r"cells\[0, 3\] is 4"),
        ({"cells": [[0, 1, 2, 3]], "cell_type": "tetra"}, "tetra cells need nodes in 3D"),
    ],
)
def test_an_impossible_lattice_is_refused_naming_the_entry(changes, sentence):
    with pytest.raises(UserError, match=sentence):
        lattice(**changes)


def test_straight_springs_are_parallel_to_one_axis_up_to_rounding():
    nodes = [[0.0, 0.0], [1.0, 1e-12], [1.0, 1.0]]
    assert SpringLattice(nodes, [[0, 1], [1, 2], [0, 2]]).straight.tolist() == [True, True, False]


def test_the_papers_grid_has_40_straight_springs_of_which_16_lie_on_the_boundary():
    grid = SpringLattice.grid((5, 5))
    assert grid.straight.sum() == 40
    assert grid.boundary.sum() == 16
    assert np.all(grid.straight[grid.boundary])


def test_on_the_surface_of_a_cube_straight_springs_are_edges_and_diagonals_cross_faces():
    grid = SpringLattice.grid((4, 4, 4))
    assert np.sum(grid.boundary & grid.straight) == 12 * 3 + 6 * 12
    assert np.sum(grid.boundary & ~grid.straight) == 6 * 9 * 2


def test_a_spring_through_the_body_is_no_boundary_spring():
    ladder = SpringLattice.grid((2, 3))
    rung = np.flatnonzero((ladder.springs == [2, 3]).all(axis=1))
    assert not ladder.boundary[rung].any()


def test_the_order_of_a_springs_nodes_does_not_matter_to_its_boundary():
    grid = SpringLattice.grid((3, 3))
    turned = SpringLattice(grid.nodes, grid.springs[:, ::-1], cells=grid.cells, cell_type=grid.cell_type)
    np.testing.assert_array_equal(turned.boundary, grid.boundary)


def test_without_cells_the_boundary_is_unknown():
    with pytest.raises(UserError, match="no cells"):
        _ = lattice().boundary


def test_sides_of_a_square_are_its_edges():
    grid = SpringLattice.grid((3, 3))
    assert np.flatnonzero(side(grid, "left")).tolist() == [0, 3, 6]
    assert np.flatnonzero(side(grid, "right")).tolist() == [2, 5, 8]
    assert np.flatnonzero(side(grid, "bottom")).tolist() == [0, 1, 2]
    assert np.flatnonzero(side(grid, "top")).tolist() == [6, 7, 8]


@pytest.mark.parametrize(
    ("name", "axis", "end"),
    [("left", 0, 0), ("right", 0, 3), ("front", 1, 0), ("back", 1, 3), ("bottom", 2, 0), ("top", 2, 3)],
)
def test_sides_of_a_cube_are_its_faces(name, axis, end):
    grid = SpringLattice.grid((4, 4, 4))
    np.testing.assert_array_equal(side(grid, name), grid.nodes[:, axis] == end)


@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e9])
def test_a_side_is_found_in_any_unit_and_through_rounding(scale):
    nodes = scale * (SQUARE + 1e-13 * np.arange(8).reshape(4, 2))
    assert np.flatnonzero(side(lattice(nodes=nodes), "left")).tolist() == [0, 2]


def test_an_unknown_side_is_refused_with_a_hint():
    with pytest.raises(UserError, match=r"left, right, bottom, top, not 'lefft'\. Did you mean 'left'"):
        side(lattice(), "lefft")
