"""Regular grids: how their nodes are numbered, which are neighbours, and how they divide into cells."""

from collections.abc import Callable, Sequence
from itertools import permutations, product

import numpy as np

from springopt.checks import Floats, Integers, floats, integers, require_positive
from springopt.errors import UserError, did_you_mean

#: Whether a step to a neighbour, its size along each axis and within the radius, belongs to the neighbourhood.
_NEIGHBOURHOODS: dict[str, Callable[[list[int], int], bool]] = {
    "moore": lambda sizes, radius: True,
    "face-diagonal": lambda sizes, radius: bool(np.count_nonzero(sizes) <= 2),
    "von-neumann": lambda sizes, radius: sum(sizes) <= radius,
}
_BLOCKS = {2: "quad", 3: "hexahedron"}
_SIMPLICES = {2: "triangle", 3: "tetra"}


class Grid:
    """A regular grid of nodes, numbered with x running fastest."""

    def __init__(self, shape: Sequence[int]) -> None:
        self.counts = tuple(int(count) for count in np.atleast_1d(integers("shape", shape)))
        if len(self.counts) not in (2, 3) or min(self.counts) < 2:
            raise UserError(f"A grid needs 2 or 3 axes with at least 2 nodes each, not {self.counts}.")
        self.dimension = len(self.counts)
        self._index = np.indices(self.counts[::-1]).reshape(self.dimension, -1)[::-1].T
        self._strides = np.cumprod((1, *self.counts[:-1]))

    def nodes(self, spacing: float | Sequence[float]) -> Floats:
        """Positions [length] for one spacing or one for each axis, shape (n, d)."""
        steps = np.atleast_1d(require_positive("spacing", floats("spacing", spacing)))
        if steps.shape not in ((1,), (self.dimension,)):
            raise UserError(f"spacing must be one number or one for each of {self.dimension} axes, not {steps.shape}.")
        return self._index * steps

    def springs(self, neighbourhood: str, radius: int) -> Integers:
        """The pairs of neighbours, lower number first, sorted, shape (s, 2)."""
        ends = self._index[:, None, :] + _offsets(self.dimension, neighbourhood, radius)
        inside = np.all((ends >= 0) & (ends < self.counts), axis=2)
        starts = np.broadcast_to((self._index @ self._strides)[:, None], inside.shape)
        pairs = np.stack([starts[inside], (ends @ self._strides)[inside]], axis=1)
        return np.unique(np.sort(pairs, axis=1), axis=0)

    def cells(self, cell_type: str) -> Integers:
        """The blocks between the nodes, or the simplices they divide into, in VTK order, shape (c, v)."""
        corners = self._index[np.all(self._index < np.array(self.counts) - 1, axis=1)] @ self._strides
        if cell_type == _BLOCKS[self.dimension]:
            x, y, *z = self._strides
            square = np.array([0, x, x + y, y])
            return corners[:, None] + (np.concatenate([square, square + z[0]]) if z else square)
        if cell_type == _SIMPLICES[self.dimension]:
            return (corners[:, None, None] + _kuhn_simplices(self._strides)).reshape(-1, self.dimension + 1)
        wanted = f"{_BLOCKS[self.dimension]!r} or {_SIMPLICES[self.dimension]!r}"
        raise UserError(f"cell must be {wanted} on a grid in {self.dimension}D, not {cell_type!r}.")


def _offsets(dimension: int, neighbourhood: str, radius: int) -> Integers:
    """Grid steps to the neighbours on one side of a node, shape (k, d)."""
    if isinstance(radius, bool) or not isinstance(radius, int) or radius < 1:
        raise UserError(f"radius must be a whole number of grid steps, at least 1, not {radius!r}.")
    if neighbourhood not in _NEIGHBOURHOODS:
        hint = did_you_mean(str(neighbourhood), _NEIGHBOURHOODS)
        raise UserError(f"neighbourhood must be one of {', '.join(_NEIGHBOURHOODS)}, not {neighbourhood!r}.{hint}")
    belongs = _NEIGHBOURHOODS[neighbourhood]
    return np.array(
        [
            step
            for step in product(range(-radius, radius + 1), repeat=dimension)
            if step > (0,) * dimension and np.gcd.reduce(step) == 1 and belongs([abs(size) for size in step], radius)
        ]
    )


def _kuhn_simplices(strides: Integers) -> Integers:
    """The simplices of one block, one for each order of walking its axes from corner to corner (Kuhn 1960).

    Neighbouring blocks divide their common face alike. Offsets of node numbers, right-handed, shape (d!, d + 1).
    """
    simplices = []
    for axes in permutations(range(len(strides))):
        walk = [0, *np.cumsum(strides[list(axes)])]
        is_odd = np.linalg.det(np.eye(len(axes))[list(axes)]) < 0
        simplices.append([*walk[:-2], walk[-1], walk[-2]] if is_odd else walk)
    return np.array(simplices)
