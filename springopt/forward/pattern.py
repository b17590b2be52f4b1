"""Which entries the tangent of a large system has, in which order: the symbolic analysis of compressed columns."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array

from springopt.forward.dissection import dissect
from springopt.forward.layout import coupled_unknowns
from springopt.forward.plan import Plan

Integers = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Pattern:
    """Which entries a matrix has: the symbolic analysis."""

    order: Integers  #: the unknown eliminated at each place
    places: Integers  #: its inverse
    keys: Integers  #: column * size + row of each entry of the lower half, ascending

    @classmethod
    def of(cls, plan: Plan, *, is_dissected: bool) -> "Pattern":
        d, size = plan.dimension, len(plan.first) * plan.dimension
        blocks = plan.block_of[plan.ends]
        blocks = blocks[(blocks >= 0).all(axis=1)]
        rows, columns = coupled_unknowns(plan)
        nodes = np.argsort(np.where(plan.block_of < 0, len(plan.block_of), plan.block_of), kind="stable")
        coupled = np.unique(np.stack([rows // d, columns // d], axis=1), axis=0)
        pairs = np.concatenate([blocks, coupled])
        diagonal = np.arange(len(plan.first))
        order = dissect(plan.nodes[nodes[: len(plan.first)]], pairs) if is_dissected else diagonal
        order = (order[:, None] * d + np.arange(d)).ravel()
        places = np.empty_like(order)
        places[order] = np.arange(size)
        pairs = np.concatenate([pairs, np.stack([diagonal, diagonal], axis=1)])
        a, b = np.divmod(np.arange(d * d), d)
        keys = _keys(places, (pairs[:, :1] * d + a).ravel(), (pairs[:, 1:] * d + b).ravel())
        return cls(order, places, np.unique(keys))

    def position(self, rows: Integers, columns: Integers) -> Integers:
        """Where these entries are in `Sparse.entries`."""
        return np.searchsorted(self.keys, _keys(self.places, rows, columns))

    @cached_property
    def whole(self) -> csc_array:
        """Both halves; the data are one plus the positions in the lower half."""
        size = len(self.order)
        columns, rows = np.divmod(self.keys, size)
        off = rows != columns
        numbers = np.arange(1, len(self.keys) + 1)
        both = np.concatenate([numbers, numbers[off]])
        at = (np.concatenate([rows, columns[off]]), np.concatenate([columns, rows[off]]))
        matrix = csc_array((both, at), shape=(size, size))
        matrix.sort_indices()
        return matrix

    @cached_property
    def diagonal(self) -> Integers:
        """Positions of the diagonal, in elimination order."""
        size = len(self.order)
        return np.searchsorted(self.keys, np.arange(size) * (size + 1))


def _keys(places: Integers, rows: Integers, columns: Integers) -> Integers:
    here, there = places[rows], places[columns]
    return np.minimum(here, there) * len(places) + np.maximum(here, there)


@dataclass(eq=False)
class PatternMatrix:
    """What all matrices of one pattern hold, as `Matrix` has it."""

    pattern: Pattern
    entries: NDArray[np.float64] = field(init=False)
    scale: NDArray[np.float64] = field(init=False)
    inertia: NDArray[np.float64] = field(init=False)

    def __post_init__(self) -> None:
        self.entries = np.zeros(len(self.pattern.keys))
        self.scale = np.ones(len(self.pattern.order))
        self.inertia = np.array([0.0, 0.0, -1.0, 0.0])

    def clear(self) -> None:
        """All entries zero."""
        self.entries[:] = 0.0
