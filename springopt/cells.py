"""The cell types, with the nodes of each in VTK order: their edges, their facets, and what they bound."""

from dataclasses import dataclass

import numpy as np

from springopt.checks import Floats, Integers, integers, require_shape
from springopt.errors import UserError, did_you_mean


@dataclass(frozen=True)
class CellType:
    """One kind of cell: the local numbers of the nodes of each edge and each facet."""

    dimension: int
    node_count: int
    edges: tuple[tuple[int, ...], ...]
    facets: tuple[tuple[int, ...], ...]


_TRIANGLE_EDGES = ((0, 1), (1, 2), (2, 0))
_QUAD_EDGES = ((0, 1), (1, 2), (2, 3), (3, 0))

CELL_TYPES = {
    "triangle": CellType(2, 3, _TRIANGLE_EDGES, _TRIANGLE_EDGES),
    "quad": CellType(2, 4, _QUAD_EDGES, _QUAD_EDGES),
    "tetra": CellType(
        3,
        4,
        ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)),
        ((0, 1, 2), (0, 1, 3), (1, 2, 3), (0, 2, 3)),
    ),
    "hexahedron": CellType(
        3,
        8,
        (*_QUAD_EDGES, (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)),
        ((0, 1, 2, 3), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)),
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
