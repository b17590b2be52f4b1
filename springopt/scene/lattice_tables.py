"""[lattice]: a grid, a mesh file, or nodes and springs one by one."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Discriminator, Field, Tag

from springopt.lattice import SpringLattice
from springopt.scene.table import Numbers, Table

Count = Annotated[int, Field(ge=2)]


class GridTable(Table):
    """Nodes on a regular grid, x fastest."""

    grid: Annotated[list[Count], Field(min_length=2, max_length=3)]
    spacing: Numbers = 1.0
    neighbourhood: Literal["moore", "von-neumann", "face-diagonal"] = "moore"
    radius: Annotated[int, Field(ge=1)] = 1
    cell: Literal["quad", "triangle", "hexahedron", "tetra"] | None = None

    def build(self) -> SpringLattice:
        return SpringLattice.grid(self.grid, **self.model_dump(exclude={"grid"}))


class MeshTable(Table):
    """Nodes and cells of a mesh file, in any format that meshio reads."""

    mesh: str
    neighbourhood: Literal["edges", "cells"] = "edges"

    def build(self) -> SpringLattice:
        return SpringLattice.from_mesh(Path(self.mesh), neighbourhood=self.neighbourhood)


class NodesTable(Table):
    """Everything given."""

    nodes: list[list[float]]
    springs: list[list[int]]
    rest_lengths: list[float] | None = None
    cells: list[list[int]] | None = None
    cell_type: Literal["quad", "triangle", "hexahedron", "tetra"] | None = None

    @classmethod
    def of(cls, lattice: SpringLattice) -> NodesTable:
        """The table that builds this lattice, so that a scene stands without its mesh file."""
        return cls.model_validate(
            {
                "nodes": lattice.nodes.tolist(),
                "springs": lattice.springs.tolist(),
                "rest_lengths": lattice.rest_lengths.tolist(),
                "cells": None if lattice.cells is None else lattice.cells.tolist(),
                "cell_type": lattice.cell_type,
            }
        )

    def build(self) -> SpringLattice:
        return SpringLattice(**self.model_dump())


def _kind(table: object) -> str | None:
    """The name of the one table whose main key is there."""
    keys = {"grid": "GridTable", "mesh": "MeshTable", "nodes": "NodesTable"}
    given = [key for key in keys if (key in table if isinstance(table, dict) else hasattr(table, key))]
    return keys[given[0]] if len(given) == 1 else None


LatticeTable = Annotated[
    Annotated[GridTable, Tag("GridTable")]
    | Annotated[MeshTable, Tag("MeshTable")]
    | Annotated[NodesTable, Tag("NodesTable")],
    Discriminator(
        _kind,
        custom_error_type="fault",
        custom_error_message="should have one of grid, mesh and nodes",
    ),
]
