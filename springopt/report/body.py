"""What one sees of a body on paper: its lines and faces, seen from the front and a little above."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from springopt.cells import CELL_TYPES, boundary_facets, edges
from springopt.checks import Booleans, Floats, Integers
from springopt.lattice import SpringLattice

_AZIMUTH, _ELEVATION = np.radians([25.0, 20.0])


@dataclass(frozen=True, eq=False)
class Body:
    """The visible part of a lattice."""

    lines: Integers  #: pairs of nodes, shape (l, 2)
    faces: Integers  #: nodes of each visible face, shape (f, v); none without cells
    seen: Booleans  #: which nodes no face hides, shape (n,)
    springs: Booleans  #: which springs are drawn: all of a flat body, those along its lines in 3D, shape (s,)


def visible(lattice: SpringLattice) -> Body:
    """Cells in 2D, the facets that face the viewer in 3D, the springs where there are no cells."""
    all_nodes, all_springs = (np.ones(count, dtype=bool) for count in (lattice.node_count, lattice.spring_count))
    if lattice.cells is None or lattice.cell_type is None:
        return Body(lattice.springs, np.empty((0, 3), dtype=int), all_nodes, all_springs)
    if lattice.dimension == 2:
        return Body(edges(lattice.cells, lattice.cell_type), lattice.cells, all_nodes, all_springs)
    faces = boundary_facets(lattice.cells, lattice.cell_type)
    faces = faces[_face_viewer(lattice.nodes, faces, _owners(lattice.cells, lattice.cell_type, faces))]
    lines = edges(faces, "triangle" if faces.shape[1] == 3 else "quad")
    seen = np.isin(np.arange(lattice.node_count), faces)
    return Body(lines, faces, seen, _among(lattice.springs, lines, lattice.node_count))


def project(positions: Floats) -> Floats:
    """Positions, shape (..., n, d), on paper, shape (..., n, 2), by parallel projection."""
    return positions if positions.shape[-1] == 2 else positions @ _paper_axes().T


def _among(springs: Integers, lines: Integers, node_count: int) -> Booleans:
    """Which springs join the nodes of a line, shape (s,)."""
    return np.isin(np.sort(springs, axis=1) @ [node_count, 1], np.sort(lines, axis=1) @ [node_count, 1])


def _viewer() -> Floats:
    """The direction to the viewer."""
    return np.array([np.sin(_AZIMUTH) * np.cos(_ELEVATION), -np.cos(_AZIMUTH) * np.cos(_ELEVATION), np.sin(_ELEVATION)])


def _paper_axes() -> Floats:
    right = np.array([np.cos(_AZIMUTH), np.sin(_AZIMUTH), 0.0])
    return np.array([right, np.cross(_viewer(), right)])


def _face_viewer(nodes: Floats, faces: Integers, owners: Integers) -> Booleans:
    """Which facets show the viewer their outside: the side where the cell that they bound is not."""
    corners = nodes[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, -1] - corners[:, 0])
    outside = corners.mean(axis=1) - nodes[owners].mean(axis=1)
    normals *= np.sign(np.sum(normals * outside, axis=1, keepdims=True))
    return normals @ _viewer() > 1e-9 * np.abs(normals).max()


def _owners(cells: Integers, cell_type: str, faces: Integers) -> Integers:
    """The cell behind each boundary facet, by its nodes, shape (f, v)."""
    local = CELL_TYPES[cell_type].facets
    owner = {frozenset(cell[list(facet)].tolist()): cell for cell in cells for facet in local}
    return np.array([owner[frozenset(face.tolist())] for face in faces])
