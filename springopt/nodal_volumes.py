"""The volume that belongs to each node of a mesh: the integral of its shape function, which sums up to the body's.

Times a density they are the row sums of the finite element mass matrix, and times a body force its consistent nodal
loads, so that a lattice and a finite element body of the same cells weigh the same, node by node.
"""

from itertools import product

import numpy as np

from springopt.checks import Floats, Integers

#: Two Gauss points in each direction are exact for the product of a shape function and the Jacobian.
GAUSS = 0.5 / np.sqrt(3.0)
#: The corners of the unit square and cube in VTK order.
_QUAD = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
_HEXAHEDRON = np.array([[*corner, z] for z in (0, 1) for corner in _QUAD.tolist()])
_CORNERS = {"quad": _QUAD, "hexahedron": _HEXAHEDRON}


def nodal_volumes(nodes: Floats, cells: Integers, cell_type: str) -> Floats:
    """[length^d], shape (n,), of regular cells (c, v)."""
    shares = (
        _simplex_shares(nodes[cells]) if cell_type in ("triangle", "tetra") else _box_shares(nodes, cells, cell_type)
    )
    return np.bincount(cells.ravel(), shares.ravel(), minlength=len(nodes)).astype(np.float64)


def _simplex_shares(corners: Floats) -> Floats:
    d = corners.shape[2]
    volumes = np.linalg.det(corners[:, 1:] - corners[:, :1]) / (2.0 if d == 2 else 6.0)
    return np.repeat(volumes[:, None] / (d + 1), d + 1, axis=1)


def _box_shares(nodes: Floats, cells: Integers, cell_type: str) -> Floats:
    corners = _CORNERS[cell_type]
    shares: Floats = np.zeros(cells.shape)
    for signs in product((-1, 1), repeat=corners.shape[1]):
        point = 0.5 + GAUSS * np.array(signs)
        factors = np.where(corners == 1, point, 1.0 - point)
        shapes = factors.prod(axis=1)
        slopes = np.where(corners == 1, 1.0, -1.0) * shapes[:, None] / factors
        jacobians = np.einsum("va,cvb->cab", slopes, nodes[cells])
        shares += np.linalg.det(jacobians)[:, None] * shapes / 2.0 ** corners.shape[1]
    return shares
