"""What all equilibria with the same supports share: the numbering of the unknowns, and where springs add up.

Nodes with a free degree of freedom become block rows of the tangent, in the order that gives the slimmest envelope
among the axes' lexicographic ones. A supported degree of freedom of a partly free node stays in its block, as a pinned
row.
"""

from collections.abc import Sequence
from itertools import permutations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from springopt.effects.effect import Kernel
from springopt.effects.springs import springs_of
from springopt.forward.terms import Term, Terms
from springopt.lattice import SpringLattice

# Columns of `Calls.table`.
(
    ADDRESS,
    BETWEEN,  # address of the discrete gradient, 0 where there is none
    EXPANDS,  # 1 where small displacements may take its expansion at rest
    INTEGERS,  # where its own begin, and so for the others
    NUMBERS,
    VALUES,
    PLACES,
    COLUMN_COUNT,
) = range(8)


class Calls(NamedTuple):
    """The kernels that the loop calls, and what each of them reads, one behind the other.

    In few arrays, since numba counts the references of all that are handed over.
    """

    table: NDArray[np.int64]  # (e, 7), a row for each, columns as numbered above
    integers: NDArray[np.int64]
    numbers: NDArray[np.float64]
    places: NDArray[np.int64]  # of blocks in the envelope, see `effects.effect`
    coupled_places: NDArray[np.int64]  # of the same blocks in the list `Plan.coupled`


class Plan(NamedTuple):
    """Arrays that the kernels read; a NamedTuple because numba takes those as they are."""

    dimension: int
    nodes: NDArray[np.float64]  # (n, d)
    ends: NDArray[np.int64]  # (s, 2)
    rest_vectors: NDArray[np.float64]  # (s, d), from the first end to the second
    lengths: NDArray[np.float64]  # (s,), of the rest vectors
    natural_lengths: NDArray[np.float64]  # (s,), L0
    prestrains: NDArray[np.float64]  # (s,), |D| - L0
    block_of: NDArray[np.int64]  # (n,), block row of a node, -1 if it is held
    first: NDArray[np.int64]  # (B,), first block of each block row
    start: NDArray[np.int64]  # (B,), position of that block in the envelope
    block_count: int
    block_rows: NDArray[np.int64]  # (s, 3), rows of the tangent where blocks (i, i), (j, j), (i, j) begin, -1: none
    pinned: NDArray[np.int64]  # supported degrees of freedom of partly free nodes, as unknowns
    pinned_rows: NDArray[np.int64]  # rows of the tangent to clear for them
    supported: NDArray[np.int64]  # supported degrees of freedom, as node * d + axis
    step_limit: float  # how far a node moves in a first step: a typical spring's length
    value_count: int  # columns of a candidate behind the stiffness
    potentials: Calls
    coupled: NDArray[np.int64]  # (q, 2), the blocks (row, column) that kernels add to, row >= column


def make_plan(terms: Terms, supports: NDArray[np.bool_]) -> Plan:
    """The plan for supports (n, d)."""
    lattice = terms.lattice
    d, springs = lattice.dimension, springs_of(lattice)
    ends = springs.ends
    kernels = terms.potentials + terms.dissipations
    pairs = np.concatenate([ends, *(kernel.pairs for _, kernel in kernels)])
    block_of, first = _slimmest_order(lattice, pairs, np.count_nonzero(supports, axis=1) < d)
    widths = np.arange(len(first)) - first + 1
    start = np.cumsum(widths) - widths
    coupled = _coupled_blocks(pairs[len(ends) :], block_of)
    pinned, pinned_rows = _pinned(supports, block_of, first, start)
    return Plan(
        dimension=d,
        nodes=np.ascontiguousarray(lattice.nodes, dtype=np.float64),
        **springs._asdict(),
        block_of=block_of,
        first=first,
        start=start,
        block_count=int(widths.sum()),
        block_rows=_block_rows(ends, block_of, first, start, d),
        pinned=pinned,
        pinned_rows=pinned_rows,
        supported=np.flatnonzero(supports.ravel()),
        step_limit=_typical_length(springs.lengths, lattice.rest_lengths),
        value_count=len(terms.defaults),
        potentials=_make_calls(terms.potentials, block_of, (first, start), coupled, d),
        coupled=coupled,
    )


def without_effects(plan: Plan) -> Plan:
    """The same springs alone."""
    return plan._replace(potentials=plan.potentials._replace(table=plan.potentials.table[:0]))


def as_at_rest(plan: Plan) -> Plan:
    """With those potentials alone that have an expansion at rest: what may stand for all of a motion or a load."""
    return plan._replace(potentials=_some(plan.potentials, plan.potentials.table[:, EXPANDS] == 1))


def _some(calls: Calls, which: NDArray[np.bool_], column: int = ADDRESS) -> Calls:
    """Some of the calls, at the addresses in this column."""
    table = calls.table[which].copy()
    table[:, ADDRESS] = table[:, column]
    return calls._replace(table=table)


Ways = tuple[Calls, Calls, Calls]


def ways_of(plan: Plan, terms: Terms, *, is_midpoint: bool) -> Ways:
    """Potentials that a step in time calls at single states, those that bring their discrete gradient, dissipations.

    Only where forces are taken on the way of the step, `is_midpoint`, are there any of the second kind.
    """
    has_own = (plan.potentials.table[:, BETWEEN] != 0) & is_midpoint
    envelope = (plan.first, plan.start)
    dissipations = _make_calls(terms.dissipations, plan.block_of, envelope, plan.coupled, plan.dimension)
    return _some(plan.potentials, ~has_own), _some(plan.potentials, has_own, BETWEEN), dissipations


def _coupled_blocks(pairs: NDArray[np.int64], block_of: NDArray[np.int64]) -> NDArray[np.int64]:
    blocks = block_of[pairs]
    blocks = blocks[(blocks >= 0).all(axis=1)]
    ordered = np.stack([blocks.max(axis=1, initial=-1), blocks.min(axis=1, initial=len(block_of))], axis=1)
    return np.unique(ordered, axis=0)


def _make_calls(
    terms: Sequence[tuple[Term, Kernel]],
    block_of: NDArray[np.int64],
    envelope: tuple[NDArray[np.int64], NDArray[np.int64]],
    coupled: NDArray[np.int64],
    d: int,
) -> Calls:
    pairs = np.concatenate([np.zeros((0, 2), dtype=np.int64), *(kernel.pairs for _, kernel in terms)])
    i, j = block_of[pairs].T
    row, column = np.maximum(i, j), np.minimum(i, j)
    exists, is_turned = column >= 0, i < j
    first, start = envelope
    places = np.full(len(pairs), -1, dtype=np.int64)
    places[exists] = 2 * (start[row[exists]] + column[exists] - first[row[exists]]) * d * d + is_turned[exists]
    listed = np.full(len(pairs), -1, dtype=np.int64)
    keys = coupled @ [len(block_of), 1]
    listed[exists] = 2 * np.searchsorted(keys, row[exists] * len(block_of) + column[exists]) * d * d + is_turned[exists]
    table = np.zeros((len(terms), COLUMN_COUNT), dtype=np.int64)
    sizes = np.array([(len(k.integers), len(k.numbers), len(k.pairs)) for _, k in terms], dtype=np.int64).reshape(-1, 3)
    table[:, [INTEGERS, NUMBERS, PLACES]] = np.cumsum(sizes, axis=0) - sizes
    for row, (term, kernel) in zip(table, terms, strict=True):
        row[ADDRESS], row[VALUES] = kernel.function.address, term.first
        row[BETWEEN] = kernel.between.address if kernel.between else 0
        row[EXPANDS] = term.effect.has_expansion_at_rest
    return Calls(
        table=table,
        integers=np.concatenate([np.zeros(0, dtype=np.int64), *(k.integers for _, k in terms)]),
        numbers=np.concatenate([np.zeros(0), *(k.numbers for _, k in terms)]),
        places=places,
        coupled_places=listed,
    )


def _typical_length(lengths: NDArray[np.float64], natural: NDArray[np.float64]) -> float:
    for candidates in (lengths, natural):
        positive = candidates[candidates > 0]
        if len(positive):
            return float(np.median(positive))
    return 1.0


def _slimmest_order(
    lattice: SpringLattice, couplings: NDArray[np.int64], is_free: NDArray[np.bool_]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """(block_of, first) of the order with the least work to factorize."""
    best: tuple[float, NDArray[np.int64], NDArray[np.int64]] | None = None
    for axes in permutations(range(lattice.dimension)):
        order = np.lexsort([lattice.nodes[:, a] for a in axes])
        order = order[is_free[order]]
        block_of = np.full(len(is_free), -1, dtype=np.int64)
        block_of[order] = np.arange(len(order))
        first = _first_neighbours(couplings, block_of, len(order))
        work = float(((np.arange(len(first)) - first + 1.0) ** 2).sum())
        if best is None or work < best[0]:
            best = work, block_of, first
    assert best is not None  # a dimension has at least one axis
    return best[1], best[2]


def _first_neighbours(couplings: NDArray[np.int64], block_of: NDArray[np.int64], count: int) -> NDArray[np.int64]:
    first = np.arange(count, dtype=np.int64)
    blocks = block_of[couplings]
    blocks = blocks[(blocks >= 0).all(axis=1)]
    np.minimum.at(first, blocks.max(axis=1), blocks.min(axis=1))
    return first


def _block_rows(
    ends: NDArray[np.int64],
    block_of: NDArray[np.int64],
    first: NDArray[np.int64],
    start: NDArray[np.int64],
    d: int,
) -> NDArray[np.int64]:
    rows = np.full((len(ends), 3), -1, dtype=np.int64)
    i, j = block_of[ends].T
    for column, (a, b) in enumerate(((i, i), (j, j), (np.maximum(i, j), np.minimum(i, j)))):
        exists = (a >= 0) & (b >= 0)
        rows[exists, column] = (start[a[exists]] + b[exists] - first[a[exists]]) * d * d
    return rows


def _pinned(
    supports: NDArray[np.bool_], block_of: NDArray[np.int64], first: NDArray[np.int64], start: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Unknowns that supports hold, and the rows of the tangent in their rows and columns."""
    d = supports.shape[1]
    nodes, axes = np.nonzero(supports & (block_of >= 0)[:, None])
    pinned = block_of[nodes] * d + axes
    axes_of = np.arange(d)
    rows = [np.zeros(0, dtype=np.int64)]
    for block, axis in zip(block_of[nodes], axes, strict=True):
        columns = np.arange(first[block], block + 1)
        rows.append((((start[block] + columns - first[block]) * d + axis) * d)[:, None] + axes_of)
        below = block + np.flatnonzero(first[block:] <= block)
        rows.append((((start[below] + block - first[below]) * d * d) + axis)[:, None] + axes_of * d)
    return pinned.astype(np.int64), np.unique(np.concatenate([block.ravel() for block in rows]))
