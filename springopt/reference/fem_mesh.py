"""What a finite element reference may be built on, as nodes, cells and their type."""

from typing import Any

import numpy as np

from springopt.cells import check_cells, require_regular_cells
from springopt.checks import Floats, Integers, floats, require_finite, require_shape
from springopt.errors import UserError
from springopt.lattice import SpringLattice
from springopt.mesh import read_mesh


def fem_mesh(mesh: Any) -> tuple[Floats, Integers, str]:
    """Nodes (n, d) [length], regular cells (c, v) and cell type of whatever was given, every node in some cell."""
    nodes, cells, cell_type = _parts(mesh)
    stray = np.setdiff1d(np.arange(len(nodes)), cells)
    if len(stray):
        raise UserError(f"Node {stray[0]} belongs to no cell; a finite element reference can't tell where it goes.")
    require_regular_cells(nodes, cells, cell_type)
    return nodes, cells, cell_type


def bare_lattice(nodes: Floats, cells: Integers, cell_type: str) -> SpringLattice:
    """The mesh as a lattice without springs, for effects to act on."""
    return SpringLattice(nodes, np.zeros((0, 2), np.int64), cells=cells, cell_type=cell_type)


def _parts(mesh: Any) -> tuple[Floats, Integers, str]:
    if isinstance(mesh, SpringLattice):
        if mesh.cells is None or mesh.cell_type is None:
            raise UserError("A finite element reference needs a lattice with cells; give it cells and cell_type.")
        return mesh.nodes, mesh.cells, mesh.cell_type
    if isinstance(mesh, tuple):
        if len(mesh) != 3:
            raise UserError(f"A mesh given as a tuple must be (nodes, cells, cell type), not {len(mesh)} things.")
        nodes = require_finite("nodes", require_shape("nodes", floats("nodes", mesh[0]), ("n", "d")))
        return nodes, check_cells(mesh[1], mesh[2], nodes), mesh[2]
    return read_mesh(mesh)
