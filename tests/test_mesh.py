import meshio
import numpy as np
import pytest

from springopt.errors import UserError
from springopt.lattice import SpringLattice

POINTS = np.array([[0.0, 0.0, 0.0], [9.0, 9.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
QUAD = np.array([[0, 2, 3, 4]])


def test_edges_of_the_cells_become_springs():
    lattice = SpringLattice.from_mesh(meshio.Mesh(POINTS, {"quad": QUAD}))
    assert lattice.springs.tolist() == [[0, 1], [0, 3], [1, 2], [2, 3]]


def test_every_pair_of_nodes_of_a_cell_can_become_a_spring():
    lattice = SpringLattice.from_mesh(meshio.Mesh(POINTS, {"quad": QUAD}), neighbourhood="cells")
    assert lattice.spring_count == 6


def test_a_grid_of_hexahedra_gets_its_moore_neighbourhood_from_its_cells():
    grid = SpringLattice.grid((3, 4, 3))
    lattice = SpringLattice.from_mesh(meshio.Mesh(grid.nodes, {"hexahedron": grid.cells}), neighbourhood="cells")
    np.testing.assert_array_equal(lattice.springs, grid.springs)


def test_a_flat_mesh_loses_its_third_coordinate_and_nodes_without_cells():
    lattice = SpringLattice.from_mesh(meshio.Mesh(POINTS, {"quad": QUAD}))
    assert lattice.nodes.tolist() == [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
    assert lattice.cells.tolist() == [[0, 1, 2, 3]]


def test_cells_of_the_highest_dimension_count():
    mesh = meshio.Mesh(POINTS, {"line": [[0, 2]], "vertex": [[1]], "quad": QUAD})
    assert SpringLattice.from_mesh(mesh).cell_type == "quad"


def test_blocks_of_one_type_are_joined():
    points = np.vstack([POINTS, [[2.0, 0.0, 0.0], [2.0, 1.0, 0.0]]])
    mesh = meshio.Mesh(points, [("quad", QUAD), ("quad", [[2, 5, 6, 3]])])
    assert len(SpringLattice.from_mesh(mesh).cells) == 2


@pytest.mark.parametrize(
    ("cells", "sentence"),
    [
        ({"triangle6": [[0, 1, 2, 3, 4, 0]]}, "this one holds triangle6"),
        ({"quad": QUAD, "triangle": [[0, 2, 3]]}, "mixes quad and triangle"),
        ({}, "holds no cells"),
    ],
)
def test_meshes_with_other_cells_are_refused(cells, sentence):
    with pytest.raises(UserError, match=sentence):
        SpringLattice.from_mesh(meshio.Mesh(POINTS, cells))


def test_a_curved_surface_is_refused():
    points = POINTS + [[0.0, 0.0, 0.5]] * np.arange(5)[:, None]
    with pytest.raises(UserError, match="quad cells need nodes in 2D"):
        SpringLattice.from_mesh(meshio.Mesh(points, {"quad": QUAD}))


def test_a_file_is_read(tmp_path):
    meshio.Mesh(POINTS, {"quad": QUAD}).write(tmp_path / "square.vtu")
    assert SpringLattice.from_mesh(str(tmp_path / "square.vtu")).node_count == 4


def test_a_file_that_is_missing_or_no_mesh_is_refused_in_silence(tmp_path, capsys):
    with pytest.raises(UserError, match=r"none\.msh does not exist"):
        SpringLattice.from_mesh(tmp_path / "none.msh")
    for name in ("broken.msh", "broken.vtu", "broken.unknown"):
        (tmp_path / name).write_text("this is no mesh")
        with pytest.raises(UserError, match="can't be read"):
            SpringLattice.from_mesh(tmp_path / name)
    assert capsys.readouterr().out == ""


def test_what_is_no_mesh_is_refused():
    with pytest.raises(UserError, match="not list"):
        SpringLattice.from_mesh([POINTS, QUAD])


def test_an_unknown_neighbourhood_is_refused():
    with pytest.raises(UserError, match="'edges' or 'cells' on a mesh, not 'moore'"):
        SpringLattice.from_mesh(meshio.Mesh(POINTS, {"quad": QUAD}), neighbourhood="moore")
