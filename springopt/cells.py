"""The cell types, with the nodes of each in VTK order: their edges, facets and corners."""

from dataclasses import dataclass

import numpy as np

from springopt.checks import Floats, Integers, integers, require_shape
from springopt.errors import UserError, did_you_mean

#: A corner whose volume is a smaller share of the product of its edges counts as flat.
FLATNESS = 1e-10


@dataclass(frozen=True)
class CellType:
    """One kind of cell: the local numbers of the nodes of each edge and each facet, and each corner's neighbours.

    A corner is followed by its neighbours in right-handed order.
    """

    dimension: int
    node_count: int
    edges: tuple[tuple[int, ...], ...]
    facets: tuple[tuple[int, ...], ...]
    corners: tuple[tuple[int, ...], ...]


_TRIANGLE_EDGES = ((0, 1), (1, 2), (2, 0))
_QUAD_EDGES = ((0, 1), (1, 2), (2, 3), (3, 0))

CELL_TYPES = {
    "triangle": CellType(2, 3, _TRIANGLE_EDGES, _TRIANGLE_EDGES, ((0, 1, 2),)),
    "quad": CellType(2, 4, _QUAD_EDGES, _QUAD_EDGES, ((0, 1, 3), (1, 2, 0), (2, 3, 1), (3, 0, 2))),
    "tetra": CellType(
        3,
        4,
        ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)),
        ((0, 1, 2), (0, 1, 3), (1, 2, 3), (0, 2, 3)),
        ((0, 1, 2, 3),),
    ),
    "hexahedron": CellType(
        3,
        8,
        (*_QUAD_EDGES, (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)),
        ((0, 1, 2, 3), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)),
        (
            *((0, 1, 3, 4), (1, 2, 0, 5), (2, 3, 1, 6), (3, 0, 2, 7)),
            *((4, 7, 5, 0), (5, 4, 6, 1), (6, 5, 7, 2), (7, 6, 4, 3)),
        ),
    ),
}


def check_cells(cells: Integers, cell_type: str, nodes: Floats) -> Integers:
    """The cells (c, v) as integers, if their type is known and fits the nodes (n, d)."""
    if cell_type not in CELL_TYPES:
        known = ", ".join(CELL_TYPES)
        raise UserError(
            f"cell_type must be one of {known}, not {cell_type!r}.{did_you_mean(str(cell_type), CELL_TYPES)}"
        )
    kind = CELL_TYPES[cell_type]
    if kind.dimension != nodes.shape[1]:
        raise UserError(f"{cell_type} cells need nodes in {kind.dimension}D, but the nodes are in {nodes.shape[1]}D.")
    cells = require_shape("cells", integers("cells", cells), ("c", kind.node_count))
    return require_nodes("cells", cells, len(nodes))


def require_nodes(name: str, numbers: Integers, node_count: int) -> Integers:
    """Refuses node numbers outside 0 ... node_count - 1; -1 does not mean the last node."""
    wrong = np.argwhere((numbers < 0) | (numbers >= node_count))
    if len(wrong):
        entry = wrong[0]
        raise UserError(
            f"{name}[{', '.join(map(str, entry))}] is {numbers[tuple(entry)]}, "
            f"but the nodes are numbered 0 to {node_count - 1}."
        )
    return numbers


def require_regular_cells(nodes: Floats, cells: Integers, cell_type: str) -> None:
    """Refuses cells with a corner that is flat or turned inside out, the first by its number."""
    corners = nodes[cells[:, CELL_TYPES[cell_type].corners]]
    arms = corners[:, :, 1:] - corners[:, :, :1]
    volumes = np.linalg.det(arms)
    limits = FLATNESS * np.prod(np.linalg.norm(arms, axis=3), axis=2)
    wrong = np.flatnonzero(np.any(volumes <= limits, axis=1))
    if len(wrong):
        cell = wrong[0]
        if np.all(volumes[cell] < -limits[cell]):
            raise UserError(f"cells[{cell}] is inverted: list its nodes in VTK order, right-handed.")
        raise UserError(f"cells[{cell}] is degenerate: it is flat or turned inside out at a corner; move its nodes.")


def edges(cells: Integers, cell_type: str) -> Integers:
    """The edges of the cells, each once, sorted, shape (e, 2)."""
    return _unique_pairs(cells[:, CELL_TYPES[cell_type].edges].reshape(-1, 2))


def node_pairs(cells: Integers) -> Integers:
    """Every pair of nodes that share a cell (or another row of nodes), each once, sorted, shape (p, 2)."""
    return _unique_pairs(cells[:, np.stack(np.triu_indices(cells.shape[1], k=1), axis=1)].reshape(-1, 2))


def boundary_facets(cells: Integers, cell_type: str) -> Integers:
    """The facets that belong to one cell only, shape (f, nodes of a facet)."""
    facets = cells[:, CELL_TYPES[cell_type].facets]
    facets = facets.reshape(-1, facets.shape[-1])
    _, first, count = np.unique(np.sort(facets, axis=1), axis=0, return_index=True, return_counts=True)
    return facets[first[count == 1]]


def _unique_pairs(pairs: Integers) -> Integers:
    return np.unique(np.sort(pairs, axis=1), axis=0)
