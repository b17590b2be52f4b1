"""What one sees of a body on paper."""

import numpy as np
import pytest

from springopt.lattice import SpringLattice
from springopt.report.body import project, visible


def test_all_of_a_flat_body_is_seen() -> None:
    body = visible(SpringLattice.grid((3, 3)))
    assert (len(body.faces), len(body.lines), body.seen.all()) == (4, 12, True)


@pytest.mark.parametrize(("cell", "faces"), [("hexahedron", 12), ("tetra", 24)])
def test_three_sides_of_a_block_are_seen(cell: str, faces: int) -> None:
    lattice = SpringLattice.grid((3, 3, 3), cell=cell)
    body = visible(lattice)
    assert len(body.faces) == faces
    x, y, z = lattice.nodes.T
    assert np.array_equal(body.seen, (x == 2) | (y == 0) | (z == 2))


def test_springs_stand_for_a_body_without_cells() -> None:
    grid = SpringLattice.grid((3, 3, 3))
    body = visible(SpringLattice(grid.nodes, grid.springs))
    assert np.array_equal(body.lines, grid.springs)
    assert len(body.faces) == 0


def test_up_stays_up_and_the_plane_stays_the_plane() -> None:
    right, up = project(np.eye(3)[[0, 2]])
    assert right[0] > 0
    assert up == pytest.approx([0, np.cos(np.radians(20))])
    assert np.array_equal(project(np.eye(2)), np.eye(2))
