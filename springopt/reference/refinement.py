"""Finer finite elements of a body that is given on a mesh: what is done to its nodes, done to all of theirs.

The nodes of the mesh stay and come first. Nodal forces do not say what they are on a finer mesh, where each would be
the more of a needle; so they are taken for what the first-order elements of the mesh can't tell from them: tractions on
the boundary, and in the inside forces by volume, that are continuous and linear on each facet, and whose work on the
mesh's own elements is exactly that of the nodal forces. So all discretizations approximate one body under one load.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.sparse import csc_matrix, csr_matrix

from springopt.cells import CELL_TYPES, boundary_facets
from springopt.checks import Booleans, Floats, Integers
from springopt.errors import UserError
from springopt.load_case import LoadCase
from springopt.reference.discretization import divided, mass_matrix, midpoints, surface_mass_matrix
from springopt.reference.factor import Factor

#: More nodes than that are refused before memory is.
MOST_NODES = 1_000_000

#: A force below this share of the largest one does not make its node one of a side that is pulled.
ROUNDING = 1e-12

Mesh = tuple[Floats, Integers, str]


class _Step(NamedTuple):
    """From the nodes of one mesh to these and those in the middle of what they are the corners of."""

    interpolation: csr_matrix  #: shape (k, n)
    facets: Integers  #: that a support fills when it holds all of their nodes, shape (f, nodes of a facet)
    on_facets: csr_matrix  #: which nodes are on which of the facets, shape (k, f)

    def supports(self, supports: Booleans) -> Booleans:
        """(k, d) of (n, d)."""
        filled = supports[self.facets].all(axis=1)
        return np.concatenate([supports, (self.on_facets @ filled.astype(float))[len(supports) :] > 0])


@dataclass(frozen=True, eq=False)
class Refinement:
    """Cells that are divided so many times, every edge in two, and elements of first or second order on them."""

    given: Mesh  #: nodes (n, d) [length], cells (c, v), cell type
    divisions: int
    order: int
    _spread: dict[bytes, Callable[[Floats], Floats]] = field(default_factory=dict, init=False, repr=False)

    def __post_init__(self) -> None:
        halvings = self.divisions + self.order - 1
        count = len(self.given[0]) * 2 ** (self.given[0].shape[1] * halvings)
        if count > MOST_NODES:
            raise UserError(
                f"The finite elements would have some {count:,} nodes, and at most {MOST_NODES:,} are tried; refine "
                "the reference less often."
            )

    @cached_property
    def mesh(self) -> Mesh:
        """The cells that bear the elements, and their corners."""
        return self._meshes[-1]

    @cached_property
    def interpolation(self) -> csr_matrix:
        """From functions that are linear in the given cells to all nodes of the elements, shape (k, n)."""
        return self._interpolation(self._steps)

    def load_case(self, case: LoadCase) -> LoadCase:
        """The load case (n, d) on all nodes of the elements (k, d).

        A support holds what lies between its nodes where these are all the nodes of a facet, each axis apart; its
        displacements are linear there. A support that fills no facet stays a point.
        """
        supports, prescribed = case.supports, case.prescribed
        for step in self._steps:
            supports = step.supports(supports)
            prescribed = np.where(supports, step.interpolation @ prescribed, 0.0)
        return replace(case, supports=supports, prescribed=prescribed, forces=self.loads(case.forces))

    def nodes_between(self, chosen: Booleans) -> Booleans:
        """Chosen nodes (n,), and those on facets all of whose nodes are chosen, shape (k,)."""
        for step in self._steps:
            chosen = step.supports(chosen[:, None])[:, 0]
        return chosen

    def boundary_shares(self, chosen: Booleans, *, alone: float) -> Floats:
        """What belongs to each chosen node (n,), by the boundary around it, divided among all nodes, shape (k,).

        It is 1 for each node on the mesh itself; a chosen node on no facet that is chosen keeps as much as `alone`.
        """
        facets = np.asarray(chosen[self._boundary].all(axis=1))
        on_facets = self._on(facets)
        shares = np.zeros(self.node_count)
        shares[: len(chosen)] = np.where(chosen & ~on_facets, alone, 0.0)
        if facets.any():
            areas = surface_mass_matrix(*self.given, self._boundary[facets]) @ np.ones(len(chosen))
            by_area = np.zeros(len(chosen))
            by_area[on_facets] = 1.0 / areas[on_facets]
            finer = surface_mass_matrix(*self.mesh, self._parts_of(facets), self.order) @ np.ones(self.node_count)
            # At the corners of second-order triangles it is 0 but for rounding.
            shares += np.maximum(finer, 0.0) * (self.interpolation @ by_area)
        return shares

    def loads(self, forces: Floats) -> Floats:
        """Nodal forces (n, d) as consistent loads (k, d) of tractions, and in the inside of forces by volume.

        Nodes that fill facets are pulled there alone. What pulls at single nodes of the boundary is spread over the
        facets around them, and fades within a few cells.
        """
        return np.stack([self._along_one_axis(column) for column in forces.T], axis=1)

    def body_loads(self, forces: Floats) -> Floats:
        """Nodal forces (n, d) as consistent loads (k, d) of forces by volume: those of weights."""
        return self._of_volume(forces)

    @property
    def node_count(self) -> int:
        """Of the elements."""
        return self.interpolation.shape[0]

    def count_points(self, supports: Booleans) -> int:
        """The number of given nodes that are held along some axis without being on a facet that is held so."""
        facets = _facets_to_fill(*self.given)
        filled = supports[facets].all(axis=1)
        on_filled = np.zeros(supports.shape, dtype=bool)
        for corner in facets.T:
            np.logical_or.at(on_filled, corner, filled)
        return int(np.any(supports & ~on_filled, axis=1).sum())

    def _along_one_axis(self, forces: Floats) -> Floats:
        """(k,) of (n,)."""
        whole = np.ones(len(self._boundary), dtype=bool)
        is_pulled = np.abs(forces) > ROUNDING * np.abs(forces).max(initial=0.0)
        sides = is_pulled[self._boundary].all(axis=1)
        on_sides, on_boundary = self._on(sides), self._on(whole)
        total = np.zeros(self.node_count)
        if sides.any():
            total += self._of_surface(sides, np.where(on_sides, forces, 0.0))
        points = np.where(on_boundary & ~on_sides, forces, 0.0)
        if points.any():
            total += self._of_surface(whole, points)
        inner = np.where(on_boundary, 0.0, forces)
        return total + self._of_volume(inner) if inner.any() else total

    def _on(self, chosen: Booleans) -> Booleans:
        """The given nodes on chosen facets of the boundary, shape (n,)."""
        on = np.zeros(len(self.given[0]), dtype=bool)
        on[self._boundary[chosen]] = True
        return on

    def _of_surface(self, chosen: Booleans, forces: Floats) -> Floats:
        key = chosen.tobytes()
        if key not in self._spread:
            coarse = surface_mass_matrix(*self.given, self._boundary[chosen])
            fine = surface_mass_matrix(*self.mesh, self._parts_of(chosen), self.order)
            nodes = np.unique(self._boundary[chosen])
            self._spread[key] = _consistent(nodes, coarse, csr_matrix(fine @ self.interpolation))
        return self._spread[key](forces)

    def _of_volume(self, forces: Floats) -> Floats:
        if b"" not in self._spread:
            coarse, fine = mass_matrix(*self.given), mass_matrix(*self.mesh, self.order)
            nodes = np.arange(len(self.given[0]))
            self._spread[b""] = _consistent(nodes, coarse, csr_matrix(fine @ self.interpolation))
        return self._spread[b""](forces)

    def _parts_of(self, chosen: Booleans) -> Integers:
        """The facets of the finer boundary that chosen ones (f,) of the given one are divided into."""
        return boundary_facets(*self.mesh[1:])[chosen[self._origins]]

    @cached_property
    def _boundary(self) -> Integers:
        """Of the given mesh, shape (f, nodes of a facet)."""
        return boundary_facets(*self.given[1:])

    @cached_property
    def _origins(self) -> Integers:
        """For each facet of the finer boundary the facet of the given one that it is a part of."""
        facets = boundary_facets(*self.mesh[1:])
        corners = _incidence(facets, len(self.mesh[0])) @ self._interpolation(self._steps[: self.divisions])
        # Between them the nodes of a part come from all the nodes of what it is a part of.
        corners.sort_indices()
        ancestors = corners.indices.reshape(len(facets), facets.shape[1])
        both = np.concatenate([np.sort(self._boundary, axis=1), ancestors])
        _, first, numbers = np.unique(both, axis=0, return_index=True, return_inverse=True)
        return first[numbers.ravel()[len(self._boundary) :]]

    @cached_property
    def _meshes(self) -> list[Mesh]:
        meshes = [self.given]
        for _ in range(self.divisions):
            meshes.append((*divided(*meshes[-1]), self.given[2]))
        return meshes

    @cached_property
    def _steps(self) -> list[_Step]:
        """One for each division, and one to the nodes of second-order elements."""
        return [_step(mesh) for mesh in (self._meshes[:-1] if self.order == 1 else self._meshes)]

    def _interpolation(self, steps: list[_Step]) -> csr_matrix:
        count = len(self.given[0])
        total = csr_matrix((np.ones(count), np.arange(count), np.arange(count + 1)), shape=(count, count))
        for step in steps:
            total = csr_matrix(step.interpolation @ total)
        return total


def _step(mesh: Mesh) -> _Step:
    interpolation, facets = midpoints(*mesh), _facets_to_fill(*mesh)
    parents = csr_matrix((np.ones(interpolation.nnz), interpolation.indices, interpolation.indptr), interpolation.shape)
    shared = csr_matrix(parents @ _incidence(facets, len(mesh[0])).T)
    # A node is on a facet if all that it is in the middle of is.
    counts = np.repeat(np.diff(interpolation.indptr), np.diff(shared.indptr))
    shared.data = (shared.data == counts).astype(float)
    return _Step(interpolation, facets, shared)


def _facets_to_fill(nodes: Floats, cells: Integers, cell_type: str) -> Integers:
    """Facets of the boundary, and others that reach inside.

    One from side to side across the body is left out: where two sides meet it is held by chance, and cuts a corner off.
    """
    outside = boundary_facets(cells, cell_type)
    is_inner = np.ones(len(nodes), dtype=bool)
    is_inner[outside] = False
    facets = cells[:, CELL_TYPES[cell_type].facets].reshape(-1, outside.shape[1])
    reaching = facets[is_inner[facets].any(axis=1)]
    _, first = np.unique(np.sort(reaching, axis=1), axis=0, return_index=True)
    return np.concatenate([outside, reaching[first]])


def _incidence(facets: Integers, node_count: int) -> csr_matrix:
    """Which nodes are on each facet, shape (f, n)."""
    count, size = facets.shape
    return csr_matrix((np.ones(facets.size), facets.ravel(), np.arange(count + 1) * size), shape=(count, node_count))


def _consistent(nodes: Integers, coarse: csc_matrix, fine: csr_matrix) -> Callable[[Floats], Floats]:
    """Of forces at the nodes the loads `fine @ t` of the densities t there for which `coarse @ t` are the forces."""
    factor = Factor.of(coarse[nodes][:, nodes])
    own = fine[:, nodes]
    return lambda forces: own @ factor.solve(np.ascontiguousarray(forces[nodes]))
