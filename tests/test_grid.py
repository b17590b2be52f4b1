import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from springopt.errors import UserError
from springopt.lattice import SpringLattice

shapes = st.lists(st.integers(2, 4), min_size=2, max_size=3)
neighbourhoods = st.sampled_from(["moore", "face-diagonal", "von-neumann"])


def cell_sizes(lattice):
    """Signed area or volume of each simplex."""
    corners = lattice.nodes[lattice.cells]
    return np.linalg.det(corners[:, 1:] - corners[:, :1]) / (2 if lattice.dimension == 2 else 6)


@pytest.mark.parametrize(("shape", "count"), [((5, 5), 72), ((4, 4, 4), 468), ((10, 10, 10), 10476)])
def test_the_papers_grids_have_the_papers_springs(shape, count):
    assert SpringLattice.grid(shape).spring_count == count


@pytest.mark.parametrize(
    ("dimension", "neighbourhood", "count"),
    [(2, "moore", 8), (2, "face-diagonal", 8), (2, "von-neumann", 4), (3, "moore", 26), (3, "face-diagonal", 18)],
)
def test_the_middle_node_has_the_neighbours_of_its_neighbourhood(dimension, neighbourhood, count):
    lattice = SpringLattice.grid((3,) * dimension, neighbourhood=neighbourhood)
    assert np.sum(lattice.springs == lattice.node_count // 2) == count


def test_nodes_are_numbered_with_x_running_fastest():
    lattice = SpringLattice.grid((3, 2, 2), spacing=(1.0, 10.0, 100.0))
    assert lattice.nodes[1].tolist() == [1.0, 0.0, 0.0]
    assert lattice.nodes[3].tolist() == [0.0, 10.0, 0.0]
    assert lattice.nodes[6].tolist() == [0.0, 0.0, 100.0]


@given(shape=shapes, neighbourhood=neighbourhoods, radius=st.integers(1, 3))
def test_springs_are_sorted_unique_and_as_long_as_their_nodes_are_apart(shape, neighbourhood, radius):
    lattice = SpringLattice.grid(shape, neighbourhood=neighbourhood, radius=radius)
    i, j = lattice.springs.T
    assert np.all(i < j)
    assert np.all(np.diff(i * lattice.node_count + j) > 0)
    np.testing.assert_allclose(lattice.rest_lengths, np.linalg.norm(lattice.nodes[j] - lattice.nodes[i], axis=1))


@given(shape=shapes, neighbourhood=neighbourhoods, radius=st.integers(1, 3))
def test_no_spring_lies_on_another(shape, neighbourhood, radius):
    lattice = SpringLattice.grid(shape, neighbourhood=neighbourhood, radius=radius)
    steps = np.diff(lattice.nodes[lattice.springs], axis=1)[:, 0].astype(int)
    assert np.all(np.gcd.reduce(steps, axis=1) == 1)


@given(shape=shapes)
def test_simplices_are_right_handed_and_fill_the_grid(shape):
    lattice = SpringLattice.grid(shape, cell="triangle" if len(shape) == 2 else "tetra")
    sizes = cell_sizes(lattice)
    assert np.all(sizes > 0)
    assert sizes.sum() == pytest.approx(np.prod(np.array(shape) - 1))


@given(shape=shapes)
def test_simplices_of_neighbouring_blocks_meet_along_common_edges(shape):
    dimension = len(shape)
    cells = SpringLattice.grid(shape, cell="triangle" if dimension == 2 else "tetra").cells
    facets = np.sort(np.concatenate([np.delete(cells, corner, axis=1) for corner in range(dimension + 1)]), axis=1)
    _, counts = np.unique(facets, axis=0, return_counts=True)
    blocks = np.array(shape) - 1
    outside = sum(2 * np.prod(np.delete(blocks, axis)) for axis in range(dimension)) * (dimension - 1)
    assert np.sum(counts == 1) == outside
    assert counts.max() <= 2


def test_blocks_are_numbered_as_vtk_does():
    assert SpringLattice.grid((5, 5)).cells[0].tolist() == [0, 1, 6, 5]
    assert SpringLattice.grid((4, 4, 4)).cells[0].tolist() == [0, 1, 5, 4, 16, 17, 21, 20]


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"shape": (5,)}, "2 or 3 axes"),
        ({"shape": 5}, "2 or 3 axes"),
        ({"shape": (5, 1)}, "at least 2 nodes each"),
        ({"shape": (5.0, 5.0)}, "shape must hold integers"),
        ({"shape": (5, 5), "spacing": -1.0}, "spacing is -1"),
        ({"shape": (5, 5), "spacing": (1.0, 1.0, 1.0)}, "one for each of 2 axes"),
        ({"shape": (5, 5), "neighbourhood": "moor"}, "Did you mean 'moore'"),
        ({"shape": (5, 5), "radius": 0}, "radius must be"),
        ({"shape": (5, 5), "radius": 1.5}, "radius must be"),
        ({"shape": (5, 5), "cell": "tetra"}, "'quad' or 'triangle' on a grid in 2D"),
    ],
)
def test_a_grid_that_cannot_be_is_refused_in_one_sentence(arguments, sentence):
    with pytest.raises(UserError, match=sentence):
        SpringLattice.grid(**arguments)
