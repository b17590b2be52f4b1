"""Where the tangent's entries go in a matrix: the symbolic analysis, made once for a set of supports.

Unknowns are numbered by the plan's blocks, d to a block. Only the lower half of the symmetric matrix is stored.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from springopt.forward.plan import Plan

Integers = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Layout:
    """Positions in a matrix's array of entries, -1 for what isn't stored."""

    springs: Integers  #: of the blocks (i, i), (j, j), (i, j) of each spring, shape (s, 3, d, d)
    coupled: Integers  #: of the entries of the blocks that kernels add to, shape (rows,)
    pinned: Integers  #: of the diagonal entries of pinned unknowns
    diagonal: Integers  #: of all diagonal entries, shape (B d,)


def lay_out(plan: Plan, position: Callable[[Integers, Integers], Integers]) -> Layout:
    """The layout of a matrix whose entry (row, column), row >= column, is at `position(row, column)`."""

    def lower(rows: Integers, columns: Integers) -> Integers:
        is_stored = (rows >= 0) & (columns >= 0)
        is_stored[is_stored] &= ~is_pinned[rows[is_stored]] & ~is_pinned[columns[is_stored]]
        places = np.full(rows.shape, -1, dtype=np.int64)
        rows, columns = rows[is_stored], columns[is_stored]
        places[is_stored] = position(np.maximum(rows, columns), np.minimum(rows, columns))
        return places

    d = plan.dimension
    is_pinned = np.zeros(len(plan.first) * d, dtype=np.bool_)
    is_pinned[plan.pinned] = True
    unknowns = np.where(plan.block_of[:, None] < 0, -1, plan.block_of[:, None] * d + np.arange(d))
    springs = np.full((len(plan.ends), 3, d, d), -1, dtype=np.int64)
    at_i, at_j = unknowns[plan.ends[:, 0]], unknowns[plan.ends[:, 1]]
    for a in range(d):
        for b in range(d):
            springs[:, 2, a, b] = lower(at_i[:, a], at_j[:, b])
            if a >= b:
                springs[:, 0, a, b] = lower(at_i[:, a], at_i[:, b])
                springs[:, 1, a, b] = lower(at_j[:, a], at_j[:, b])
    rows, columns = coupled_unknowns(plan)
    coupled = lower(rows, columns)
    coupled[(rows // d == columns // d) & (columns > rows)] = -1  # diagonal blocks are whole: take their lower half
    every = np.arange(len(plan.first) * d)
    return Layout(springs, coupled, position(plan.pinned, plan.pinned), position(every, every))


def coupled_unknowns(plan: Plan) -> tuple[Integers, Integers]:
    """(row, column) of each entry of the blocks that kernels add to."""
    d = plan.dimension
    rows, columns = plan.coupled.T
    a, b = np.divmod(np.arange(d * d), d)
    return (rows[:, None] * d + a).ravel(), (columns[:, None] * d + b).ravel()
