"""The lattice: nodes, the springs that may join them, their rest lengths, and the cells of the body they stand for."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Self

import numpy as np

from springopt.cells import boundary_facets, check_cells, edges, node_pairs, require_nodes
from springopt.checks import (
    Booleans,
    Floats,
    Integers,
    floats,
    integers,
    require_finite,
    require_nonnegative,
    require_shape,
)
from springopt.errors import UserError, did_you_mean
from springopt.grid import Grid
from springopt.mesh import read_mesh

#: A component below this share of a length counts as zero when directions and sides are judged.
RELATIVE_TOLERANCE = 1e-9

_SIDES = {
    2: {"left": (0, 0), "right": (0, 1), "bottom": (1, 0), "top": (1, 1)},
    3: {"left": (0, 0), "right": (0, 1), "front": (1, 0), "back": (1, 1), "bottom": (2, 0), "top": (2, 1)},
}


@dataclass(frozen=True, eq=False)
class SpringLattice:
    """Nodes and the springs that may join them; which of them exist, and how stiff they are, is for the model to learn.

    Two springs between the same nodes, nodes at the same place and rest lengths of zero are legal.
    """

    nodes: Floats  #: rest positions [length], shape (n, d), d = 2 or 3
    springs: Integers  #: the two nodes of each spring, shape (s, 2)
    rest_lengths: Floats = None  # type: ignore[assignment]  #: [length], shape (s,); by default the distances
    cells: Integers | None = None  #: the nodes of each cell in VTK order, shape (c, v)
    cell_type: str | None = None  #: "triangle", "quad", "tetra" or "hexahedron"

    def __post_init__(self) -> None:
        nodes = require_shape("nodes", floats("nodes", self.nodes), ("n", "d"))
        if nodes.shape[1] not in (2, 3) or not len(nodes):
            raise UserError(f"nodes must have the shape (n, 2) or (n, 3), not {nodes.shape}.")
        springs = _check_springs(self.springs, len(require_finite("nodes", nodes)))
        if self.rest_lengths is None:
            rest_lengths = np.linalg.norm(nodes[springs[:, 1]] - nodes[springs[:, 0]], axis=1)
        else:
            rest_lengths = require_shape("rest_lengths", floats("rest_lengths", self.rest_lengths), (len(springs),))
        if (self.cells is None) != (self.cell_type is None):
            raise UserError("cells and cell_type belong together: give both or neither.")
        object.__setattr__(self, "nodes", nodes)
        object.__setattr__(self, "springs", springs)
        object.__setattr__(self, "rest_lengths", require_nonnegative("rest_lengths", rest_lengths))
        if self.cells is not None and self.cell_type is not None:
            object.__setattr__(self, "cells", check_cells(self.cells, self.cell_type, nodes))

    @classmethod
    def grid(
        cls,
        shape: Sequence[int],
        *,
        spacing: float | Sequence[float] = 1.0,
        neighbourhood: str = "moore",
        radius: int = 1,
        cell: str | None = None,
    ) -> Self:
        """A regular grid of nodes; the springs join neighbours and are sorted by their nodes.

        Nodes are numbered with x running fastest. `spacing` [length] is one number or one for each axis.
        `neighbourhood`: "moore" (8 neighbours in 2D, 26 in 3D), "face-diagonal" (those that share a coordinate plane:
        8, 18) or "von-neumann" (4, 6). `radius` [grid steps] widens it: the largest step along an axis, for von-neumann
        the sum of the steps. A neighbour behind another one, in the same direction, is left out: its spring would lie
        on the springs between. `cell`: "quad" and "hexahedron" by default, or "triangle" and "tetra".
        """
        grid = Grid(shape)
        cell_type = cell or ("quad" if grid.dimension == 2 else "hexahedron")
        return cls(
            nodes=grid.nodes(spacing),
            springs=grid.springs(neighbourhood, radius),
            cells=grid.cells(cell_type),
            cell_type=cell_type,
        )

    @classmethod
    def from_mesh(cls, mesh: Any, *, neighbourhood: str = "edges") -> Self:
        """The nodes of a mesh (a file that meshio reads, or its object), joined as its cells join them.

        `neighbourhood`: "edges" for the edges of the cells, "cells" for every pair of nodes that share a cell.
        Nodes that no cell uses are left out; the others keep their order.
        """
        nodes, cells, cell_type = read_mesh(mesh)
        if neighbourhood == "edges":
            springs = edges(cells, cell_type)
        elif neighbourhood == "cells":
            springs = node_pairs(cells)
        else:
            raise UserError(f"neighbourhood must be 'edges' or 'cells' on a mesh, not {neighbourhood!r}.")
        return cls(nodes, springs, cells=cells, cell_type=cell_type)

    @property
    def node_count(self) -> int:
        return len(self.nodes)

    @property
    def spring_count(self) -> int:
        return len(self.springs)

    @property
    def dimension(self) -> int:
        return self.nodes.shape[1]

    @cached_property
    def straight(self) -> Booleans:
        """Which springs are parallel to an axis, shape (s,)."""
        sizes = np.abs(self.nodes[self.springs[:, 1]] - self.nodes[self.springs[:, 0]])
        longest = sizes.max(axis=1, initial=0.0)
        return np.count_nonzero(sizes > RELATIVE_TOLERANCE * longest[:, None], axis=1) == 1

    @cached_property
    def boundary(self) -> Booleans:
        """Which springs lie on the boundary of the cells, both ends in one boundary facet, shape (s,)."""
        if self.cells is None or self.cell_type is None:
            raise UserError("This lattice has no cells, so that its boundary is unknown; give it cells and cell_type.")
        pairs = node_pairs(boundary_facets(self.cells, self.cell_type))
        springs = np.sort(self.springs, axis=1)
        return np.isin(springs @ [self.node_count, 1], pairs @ [self.node_count, 1])


def side_names(lattice: SpringLattice) -> tuple[str, ...]:
    """What `side` calls the sides of a lattice."""
    return tuple(_SIDES[lattice.dimension])


def side(lattice: SpringLattice, name: str) -> Booleans:
    """The nodes on one side of the lattice's bounding box, shape (n,).

    "left" and "right" are the ends of x, "bottom" and "top" those of the last axis, and in 3D "front" and "back" those
    of y.
    """
    sides = _SIDES[lattice.dimension]
    if name not in sides:
        raise UserError(f"A side must be one of {', '.join(sides)}, not {name!r}.{did_you_mean(str(name), sides)}")
    axis, is_upper = sides[name]
    low, high = lattice.nodes.min(axis=0), lattice.nodes.max(axis=0)
    end = high[axis] if is_upper else low[axis]
    return np.abs(lattice.nodes[:, axis] - end) <= RELATIVE_TOLERANCE * np.max(high - low)


def _check_springs(springs: Integers, node_count: int) -> Integers:
    springs = integers("springs", springs)
    springs = require_shape("springs", springs if springs.size else springs.reshape(0, 2), ("s", 2))
    require_nodes("springs", springs, node_count)
    loops = np.flatnonzero(springs[:, 0] == springs[:, 1])
    if len(loops):
        raise UserError(f"springs[{loops[0]}] joins node {springs[loops[0], 0]} to itself; give it two nodes.")
    return springs
