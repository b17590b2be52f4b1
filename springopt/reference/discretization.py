"""Finite elements by scikit-fem: shape gradients and weights at Gauss points, masses, and the division of cells."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from scipy.sparse import csc_matrix, csr_matrix, vstack
from skfem import (
    Basis,
    ElementHex1,
    ElementHex2,
    ElementQuad1,
    ElementQuad2,
    ElementTetP1,
    ElementTetP2,
    ElementTriP1,
    ElementTriP2,
    FacetBasis,
    MeshHex1,
    MeshQuad1,
    MeshTet1,
    MeshTri1,
)
from skfem.models.poisson import mass

from springopt.checks import Floats, Integers

ORDERS = (1, 2)


class _Element(NamedTuple):
    """An element, with the integration orders that it needs."""

    element: Any
    #: Of products of gradients: with first-order elements two Gauss points a direction on quadrilaterals and
    #: hexahedra, the constant of a simplex; with second-order ones three a direction, and 3 or 4 on a simplex.
    order: int
    #: Exact for the product of two shape functions and the Jacobian.
    mass_order: int


class _Kind(NamedTuple):
    """How scikit-fem treats a cell type: its mesh, its numbering of our corners, its elements of each order."""

    mesh: Any
    corners: list[int]
    elements: dict[int, _Element]
    parents: tuple[str, ...]  #: what has a node in its middle, in the order of the nodes of the divided mesh


_KINDS = {
    "triangle": _Kind(
        MeshTri1, [0, 1, 2], {1: _Element(ElementTriP1, 1, 2), 2: _Element(ElementTriP2, 2, 4)}, ("facets",)
    ),
    "quad": _Kind(
        MeshQuad1, [0, 1, 2, 3], {1: _Element(ElementQuad1, 3, 3), 2: _Element(ElementQuad2, 5, 5)}, ("facets", "t")
    ),
    "tetra": _Kind(
        MeshTet1, [0, 1, 2, 3], {1: _Element(ElementTetP1, 1, 2), 2: _Element(ElementTetP2, 2, 4)}, ("edges",)
    ),
    "hexahedron": _Kind(
        MeshHex1,
        [6, 2, 5, 7, 1, 3, 4, 0],
        {1: _Element(ElementHex1, 3, 5), 2: _Element(ElementHex2, 5, 7)},
        ("edges", "facets", "t"),
    ),
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


def discretize(nodes: Floats, cells: Integers, cell_type: str, order: int = 1) -> Discretization:
    """The fully integrated elements of a mesh; of second order its nodes are followed by those of `midpoints`."""
    basis = _basis(nodes, cells, cell_type, order, _KINDS[cell_type].elements[order].order)
    points = basis.dx.shape
    gradients = [np.broadcast_to(shape[0].grad, (nodes.shape[1], *points)) for shape in basis.basis]
    return Discretization(
        cells=np.argsort(_numbers(basis))[basis.element_dofs].T,
        gradients=np.ascontiguousarray(np.stack(gradients).transpose(2, 3, 0, 1)),
        weights=np.array(basis.dx),
    )


def mass_matrix(nodes: Floats, cells: Integers, cell_type: str, order: int = 1) -> csc_matrix:
    """The consistent mass matrix of a unit density for one axis [length^d], shape (n, n)."""
    basis = _basis(nodes, cells, cell_type, order, _KINDS[cell_type].elements[order].mass_order)
    return _mass(basis, _numbers(basis))


def surface_mass_matrix(nodes: Floats, cells: Integers, cell_type: str, facets: Integers, order: int = 1) -> csc_matrix:
    """The same of a skin on these facets (f, nodes of a facet) of the boundary [length^(d - 1)], shape (n, n)."""
    kind, mesh = _KINDS[cell_type].elements[order], _mesh(nodes, cells, cell_type)
    known = mesh.boundary_facets()
    both = np.concatenate([np.sort(mesh.facets[:, known].T, axis=1), np.sort(facets, axis=1)])
    _, numbers = np.unique(both, axis=0, return_inverse=True)
    is_asked = np.isin(numbers.ravel()[: len(known)], numbers.ravel()[len(known) :])
    basis = FacetBasis(mesh, kind.element(), facets=known[is_asked], intorder=kind.mass_order)
    return _mass(basis, _numbers(basis))


def midpoints(nodes: Floats, cells: Integers, cell_type: str) -> csr_matrix:
    """What linear functions at the nodes are at these and in the middle of edges, facets and cells, shape (k, n).

    Which of them have a node there depends on the cell type: those that `divided` cells need, and that second-order
    elements have beside the corners.
    """
    mesh, count = _mesh(nodes, cells, cell_type), len(nodes)
    rows = [csr_matrix((np.ones(count), np.arange(count), np.arange(count + 1)), shape=(count, count))]
    for name in _KINDS[cell_type].parents:
        parents = np.asarray(getattr(mesh, name)).T
        shares, ends = np.full(parents.size, 1.0 / parents.shape[1]), np.arange(len(parents) + 1) * parents.shape[1]
        rows.append(csr_matrix((shares, parents.ravel(), ends), shape=(len(parents), count)))
    return csr_matrix(vstack(rows))


def divided(nodes: Floats, cells: Integers, cell_type: str) -> tuple[Floats, Integers]:
    """The mesh with every edge halved: its nodes are those of `midpoints`, each cell becomes 2^d of the same type."""
    mesh = _mesh(nodes, cells, cell_type).refined()
    finer = np.ascontiguousarray(mesh.p.T)
    parts = mesh.t.T[:, np.argsort(_KINDS[cell_type].corners)].astype(np.int64)
    if cell_type in ("triangle", "tetra"):  # scikit-fem does not care which way round they are
        is_inverted = np.linalg.det(finer[parts[:, 1:]] - finer[parts[:, :1]]) < 0
        parts[is_inverted, -2:] = parts[is_inverted, :-3:-1]
    return finer, parts


def _mass(basis: Any, numbers: Integers) -> csc_matrix:
    return csc_matrix(mass.assemble(basis))[numbers][:, numbers]


def _numbers(basis: Any) -> Integers:
    """scikit-fem's number of each node, those of the mesh first."""
    corners = basis.nodal_dofs[0]
    return np.concatenate([corners, np.setdiff1d(np.arange(basis.N), corners)])


def _mesh(nodes: Floats, cells: Integers, cell_type: str) -> Any:
    kind = _KINDS[cell_type]
    return kind.mesh(np.ascontiguousarray(nodes.T), np.ascontiguousarray(cells[:, kind.corners].T))


def _basis(nodes: Floats, cells: Integers, cell_type: str, order: int, integration: int) -> Any:
    element = _KINDS[cell_type].elements[order].element()
    return Basis(_mesh(nodes, cells, cell_type), element, intorder=integration)
