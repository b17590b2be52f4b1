"""First-order finite elements by scikit-fem: shape gradients and weights at the Gauss points, and the mass matrix."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from scipy.sparse import csc_matrix
from skfem import (
    Basis,
    ElementHex1,
    ElementQuad1,
    ElementTetP1,
    ElementTriP1,
    MeshHex1,
    MeshQuad1,
    MeshTet1,
    MeshTri1,
)
from skfem.models.poisson import mass

from springopt.checks import Floats, Integers


class _Kind(NamedTuple):
    """How scikit-fem treats a cell type: its mesh, its element, its numbering of our corners, its quadrature."""

    mesh: Any
    element: Any
    corners: list[int]
    #: Integration order: two Gauss points a direction on quadrilaterals and hexahedra, the constant of a simplex.
    order: int
    #: Integration order that is exact for the product of two shape functions and the Jacobian.
    mass_order: int


_KINDS = {
    "triangle": _Kind(MeshTri1, ElementTriP1, [0, 1, 2], 1, 2),
    "quad": _Kind(MeshQuad1, ElementQuad1, [0, 1, 2, 3], 3, 3),
    "tetra": _Kind(MeshTet1, ElementTetP1, [0, 1, 2, 3], 1, 2),
    "hexahedron": _Kind(MeshHex1, ElementHex1, [6, 2, 5, 7, 1, 3, 4, 0], 3, 5),
}


@dataclass(frozen=True, eq=False)
class Discretization:
    """The shape functions of a mesh, at the q Gauss points of each of its c cells with v nodes."""

    cells: Integers  #: the nodes of each cell, in the order of the gradients, shape (c, v)
    gradients: Floats  #: of the shape functions at rest [1 / length], shape (c, q, v, d)
    weights: Floats  #: the volume that a Gauss point stands for [length^d], shape (c, q)

    @property
    def dimension(self) -> int:
        return self.gradients.shape[3]


def discretize(nodes: Floats, cells: Integers, cell_type: str) -> Discretization:
    """The fully integrated elements of a mesh."""
    basis = _basis(nodes, cells, cell_type, _KINDS[cell_type].order)
    points = basis.dx.shape
    gradients = [np.broadcast_to(shape[0].grad, (nodes.shape[1], *points)) for shape in basis.basis]
    return Discretization(
        cells=np.argsort(basis.nodal_dofs[0])[basis.element_dofs].T,
        gradients=np.ascontiguousarray(np.stack(gradients).transpose(2, 3, 0, 1)),
        weights=np.array(basis.dx),
    )


def mass_matrix(nodes: Floats, cells: Integers, cell_type: str) -> csc_matrix:
    """The consistent mass matrix of a unit density for one axis [length^d], shape (n, n)."""
    basis = _basis(nodes, cells, cell_type, _KINDS[cell_type].mass_order)
    numbers = basis.nodal_dofs[0]
    return csc_matrix(mass.assemble(basis))[numbers][:, numbers]


def _basis(nodes: Floats, cells: Integers, cell_type: str, order: int) -> Any:
    kind = _KINDS[cell_type]
    mesh = kind.mesh(np.ascontiguousarray(nodes.T), np.ascontiguousarray(cells[:, kind.corners].T))
    return Basis(mesh, kind.element(), intorder=order)
