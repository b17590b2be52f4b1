"""Which motions without strain the supports of a body leave free."""

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from springopt.cells import CELL_TYPES
from springopt.checks import Booleans, Floats, Integers

#: A singular value below this share of the largest one belongs to a free motion.
RELATIVE_TOLERANCE = 1e-8


class RigidModes:
    """The rigid motions of the parts of a mesh.

    A part is what facets join: it can't move without strain but as a whole. Parts that share single nodes, or an edge
    in 3D, are hinged there, so that their motions agree at the shared nodes only.
    """

    def __init__(self, nodes: Floats, cells: Integers, cell_type: str) -> None:
        part_of_cell = _parts(cells, cell_type)
        pairs = np.unique(np.stack([cells.ravel(), np.repeat(part_of_cell, cells.shape[1])], axis=1), axis=0)
        self._nodes, parts = pairs.T
        self._motions = _motions(nodes, self._nodes, parts)
        is_again = np.flatnonzero(self._nodes[1:] == self._nodes[:-1])
        self._hinges = (self._motions[is_again + 1] - self._motions[is_again]).reshape(-1, self._motions.shape[2])

    def count_free(self, supports: Booleans) -> int:
        """The number of independent motions that the supports (n, d) do not stop."""
        rows = np.concatenate([self._hinges, self._motions[supports[self._nodes]]])
        singular_values = np.linalg.svd(rows, compute_uv=False)
        rank = np.count_nonzero(singular_values > RELATIVE_TOLERANCE * singular_values.max(initial=0.0))
        return rows.shape[1] - int(rank)


def _parts(cells: Integers, cell_type: str) -> Integers:
    """The part each cell belongs to, shape (c,)."""
    facets = cells[:, CELL_TYPES[cell_type].facets]
    _, number = np.unique(np.sort(facets.reshape(-1, facets.shape[2]), axis=1), axis=0, return_inverse=True)
    cell = np.repeat(np.arange(len(cells)), facets.shape[1])
    joins = coo_matrix((np.ones(len(cell)), (cell, number.ravel())), shape=(len(cells), number.max(initial=-1) + 1))
    return connected_components(joins @ joins.T, directed=False)[1].astype(np.int64)


def _motions(nodes: Floats, numbers: Integers, parts: Integers) -> Floats:
    """Displacements of each (node, part) in the rigid motions of all parts, of unit order, shape (p, d, motions)."""
    dimension = nodes.shape[1]
    planes = [(a, b) for a in range(dimension) for b in range(a + 1, dimension)]
    size = dimension + len(planes)
    own = np.zeros((len(numbers), dimension, size))
    arms = nodes[numbers]
    for part in np.unique(parts):
        positions = arms[parts == part]
        arms[parts == part] = (positions - positions.mean(axis=0)) / np.ptp(positions, axis=0).max()
    own[:, range(dimension), range(dimension)] = 1.0
    for mode, (a, b) in enumerate(planes, start=dimension):
        own[:, a, mode], own[:, b, mode] = -arms[:, b], arms[:, a]
    motions = np.zeros((len(numbers), dimension, int(parts.max()) + 1, size))
    motions[np.arange(len(numbers)), :, parts] = own
    return motions.reshape(len(numbers), dimension, -1)
