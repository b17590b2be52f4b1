"""Meshes of other programs as nodes, cells and their type: meshio objects, and the files it reads."""

from contextlib import redirect_stdout
from io import StringIO
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from springopt.cells import CELL_TYPES, check_cells
from springopt.checks import Floats, Integers, floats, require_finite
from springopt.errors import UserError


def read_mesh(mesh: Any) -> tuple[Floats, Integers, str]:
    """Nodes (n, d) [length], cells (c, v) and cell type of a meshio mesh or a file that meshio reads.

    Of several kinds of cells the ones of the highest dimension count; nodes that none of them uses are left out, and
    the others keep their order. A flat mesh loses its third coordinate.
    """
    if isinstance(mesh, str | PathLike):
        mesh = _read_file(Path(mesh))
    if not (hasattr(mesh, "points") and hasattr(mesh, "cells")):
        raise UserError(f"A mesh must be a file or a meshio mesh, not {type(mesh).__name__}.")
    blocks = [(block.type, np.asarray(block.data, np.int64)) for block in mesh.cells if block.type in CELL_TYPES]
    if not blocks:
        found = ", ".join(sorted({block.type for block in mesh.cells})) or "no cells"
        raise UserError(f"A mesh must hold one of {', '.join(CELL_TYPES)}; this one holds {found}.")
    dimension = max(CELL_TYPES[cell_type].dimension for cell_type, _ in blocks)
    cell_types = sorted({cell_type for cell_type, _ in blocks if CELL_TYPES[cell_type].dimension == dimension})
    if len(cell_types) > 1:
        raise UserError(f"A mesh must hold one type of cell; this one mixes {' and '.join(cell_types)}.")
    cells = np.concatenate([data for cell_type, data in blocks if cell_type == cell_types[0]])
    nodes = _without_flat_axis(require_finite("points", floats("points", mesh.points)), dimension)
    used, cells = np.unique(check_cells(cells, cell_types[0], nodes), return_inverse=True)
    return nodes[used], cells.reshape(-1, CELL_TYPES[cell_types[0]].node_count), cell_types[0]


def _without_flat_axis(points: Floats, dimension: int) -> Floats:
    if points.shape[1] == dimension + 1 and np.ptp(points[:, -1]) == 0:
        return points[:, :-1]
    return points


def _read_file(path: Path) -> Any:
    if not path.is_file():
        raise UserError(f"The mesh file {path} does not exist.")
    import meshio

    # meshio prints what went wrong and exits; a library must do neither.
    with redirect_stdout(StringIO()):
        try:
            return meshio.read(path)
        except (Exception, SystemExit) as error:
            reason = "" if isinstance(error, SystemExit) else f": {error}"
            raise UserError(f"The mesh file {path} can't be read{reason}; give any format that meshio knows.") from None
