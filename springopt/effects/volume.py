"""Volume: cells that resist a change of their volume, so that springs stand for a body of another Poisson's ratio."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations, permutations
from typing import Any

import numpy as np

from springopt.cells import CELL_TYPES, require_regular_cells
from springopt.checks import Floats, Integers, floats, require_nonnegative, require_shape
from springopt.effects.effect import NOT_FITTED, Effect, Kernel
from springopt.errors import UserError
from springopt.lattice import SpringLattice

#: The facets of a cell, seen from outside counterclockwise.
_SURFACES = {
    "tetra": ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)),
    "hexahedron": ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)),
}


@dataclass(frozen=True)
class Volume(Effect):
    """The energy modulus / 2 * V0 (V / V0 - 1)^2 of each cell, with its volume V, V0 at rest; in 2D its area.

    Exact for all cell types: the volume of a hexahedron is that of its trilinear map. V = V0 is the only minimum: a
    cell that is turned inside out has the negative volume, and is pushed back from there. A uniform modulus m adds m
    to C11 and C12 of a regular grid: nu = (C12 + m) / (C11 + m) in 2D.
    """

    name = "volume"
    modulus: float | Sequence[float]  #: [force / length^(d - 1)], one number for all cells or one for each

    def parameters(self, lattice: SpringLattice) -> dict[str, Floats]:
        if lattice.cells is None or lattice.cell_type is None:
            raise UserError("volume acts on cells, but this lattice has none; give it cells and cell_type.")
        require_regular_cells(lattice.nodes, lattice.cells, lattice.cell_type)
        modulus = require_nonnegative("modulus", floats("modulus", self.modulus))
        return {"modulus": require_shape("modulus", modulus, (len(lattice.cells),)) if modulus.ndim else modulus[None]}

    def potential(self, lattice: SpringLattice, fitted: frozenset[str] = NOT_FITTED) -> Kernel | None:
        assert lattice.cells is not None, "or there would be no parameters"
        assert lattice.cell_type is not None
        cells, corners = lattice.cells, lattice.cells.shape[1]
        local = np.array([*((p, p) for p in range(corners)), *combinations(range(corners), 2)])
        pairs = cells[:, local].reshape(-1, 2)
        arms = lattice.nodes[cells] - lattice.nodes[cells[:, :1]]
        head = np.array([len(cells), corners, np.ndim(self.modulus)])
        if lattice.dimension == 2:
            gradients = _area_gradients(arms)
            integers = np.concatenate([head, cells.ravel()])
            return Kernel(_area_kernel(), pairs, integers, _of_cells(arms, gradients, 2))
        coefficients = volume_coefficients(lattice.cell_type)
        table, weights = _listed(coefficients)
        gradients = 0.5 * np.einsum("pqr,cqra->cpa", coefficients, np.cross(arms[:, :, None], arms[:, None]))
        numbers = np.concatenate([weights, _of_cells(arms, gradients, 3)])
        return Kernel(_volume_kernel(), pairs, np.concatenate([head, table, cells.ravel()]), numbers)


def volume_coefficients(cell_type: str) -> Floats:
    """C, antisymmetric, shape (v, v, v): the volume is sum C_pqr det(x_p, x_q, x_r) / 6.

    By the divergence theorem a volume is the sum over its surface's triangles of det / 6. The bilinear facets of a
    hexahedron take the mean of both ways to cut them into triangles: Grandy (1997), Efficient computation of volume of
    hexahedral cells, UCRL-ID-128886.
    """
    count = CELL_TYPES[cell_type].node_count
    coefficients = np.zeros((count, count, count))
    for facet in _SURFACES[cell_type]:
        triangles = list(combinations(facet, 3))  # of four corners: the two cuts, four triangles
        for triangle in triangles:
            for order in permutations(range(3)):
                sign = np.linalg.det(np.eye(3)[list(order)])
                coefficients[tuple(triangle[k] for k in order)] += sign / (6.0 if len(triangles) == 1 else 12.0)
    return coefficients


def _listed(coefficients: Floats) -> tuple[Integers, Floats]:
    """The coefficients as `add_volumes` reads them: of each pair p < q its terms' end, then the terms' r; weights."""
    ends, others, weights = [], [], []
    for p, q in combinations(range(len(coefficients)), 2):
        found = np.flatnonzero(np.abs(coefficients[p, q]) > 1e-12)
        others.extend(found.tolist())
        weights.extend(coefficients[p, q, found].tolist())
        ends.append(len(others))
    return np.array([len(others), *ends, *others]), np.array(weights)


def _area_gradients(arms: Floats) -> Floats:
    """Derivatives of the areas of polygons (c, v, 2) by their corners, the shoelace formula's."""
    across = np.roll(arms, -1, axis=1) - np.roll(arms, 1, axis=1)
    return 0.5 * np.stack([across[..., 1], -across[..., 0]], axis=-1)


def _of_cells(arms: Floats, gradients: Floats, degree: int) -> Floats:
    """Of each cell its volume at rest, which is homogeneous of this degree, and the gradient of that."""
    volumes = (arms * gradients).sum(axis=(1, 2)) / degree
    return np.column_stack([volumes, gradients.reshape(len(arms), -1)]).ravel()


def _area_kernel() -> Any:
    from springopt.effects.volume_kernel import add_areas

    return add_areas


def _volume_kernel() -> Any:
    from springopt.effects.volume_kernel import add_volumes

    return add_volumes
