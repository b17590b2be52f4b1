"""Kernels called as the forward solve calls them, eight states at a time, behind rows that nothing should touch."""

from __future__ import annotations

import ctypes
from typing import Any, NamedTuple

import numpy as np

from springopt.checks import Floats, Integers
from springopt.effects.effect import Kernel
from springopt.effects.lanes import LANE_COUNT
from springopt.lattice import SpringLattice

#: Rows before and behind what a kernel may add to, and places behind those that it declared.
GUARD = 64
_UNTOUCHED = 7.25
_C_KERNEL = ctypes.CFUNCTYPE(None, ctypes.c_int64, ctypes.c_int64, *[ctypes.c_void_p] * 11)


class States(NamedTuple):
    """What a kernel reads of l equilibria."""

    displacements: Floats  # shape (l, n d)
    velocities: Floats  # shape (l, n d)
    stiffness: Floats  # shape (l, s)
    values: Floats  # shape (l, k)

    def take(self, rows: Any) -> States:
        return States(*(array[rows] for array in self))


class Answers(NamedTuple):
    """What a kernel adds for l equilibria."""

    energy: Floats  # of a dissipation the power, shape (l,)
    forces: Floats  # shape (l, n d)
    blocks: Floats  # in the order of the pairs, shape (l, q, d, d)


class Stray(Exception):
    """A kernel wrote where it may not."""


class Failed(Exception):
    """A kernel in Python raised an error, whose text this is."""


def answers(kernel: Kernel, lattice: SpringLattice, states: States) -> Answers:
    """What the kernel adds at these states, each pair with a block of its own. Raises Stray and Failed."""
    size, count = lattice.dimension**2, len(states.displacements)
    places = 2 * size * np.arange(len(kernel.pairs), dtype=np.int64)
    parts = []
    for begin in range(0, count, LANE_COUNT):
        few = np.minimum(np.arange(begin, begin + LANE_COUNT), count - 1)
        energy, forces, tangent = call(kernel, lattice, states.take(few), places, size * len(places))
        parts.append((energy[0], forces.T, tangent.T))
    energy, forces, tangent = (np.concatenate(part)[:count] for part in zip(*parts, strict=True))
    return Answers(energy, forces, tangent.reshape(count, -1, lattice.dimension, lattice.dimension))


def call(
    kernel: Kernel,
    lattice: SpringLattice,
    states: States,
    places: Integers,
    tangent_rows: int,
    before: float = 0.0,
) -> tuple[Floats, Floats, Floats]:
    """Energy (1, 8), forces (n d, 8) and tangent (rows, 8), which held the number `before`, after one call.

    Raises Stray and Failed.
    Places beyond the declared ones lead to rows that nothing may touch.
    """
    d, n = lattice.dimension, lattice.node_count
    outside = 2 * (tangent_rows + GUARD - d * d)
    all_places = np.concatenate([places, np.full(GUARD, outside, dtype=np.int64)])
    inputs = [np.ascontiguousarray(lattice.nodes), kernel.integers, kernel.numbers]
    inputs += [np.ascontiguousarray(states.stiffness.T), np.ascontiguousarray(states.values.T), all_places]
    inputs += [np.ascontiguousarray(states.displacements.T), np.ascontiguousarray(states.velocities.T)]
    outputs = [_guarded(rows, before) for rows in (n * d, tangent_rows, 1)]
    copies = [array.copy() for array in inputs]
    arrays = [array.ctypes.data for array in inputs] + [array[GUARD:].ctypes.data for array in outputs]
    _C_KERNEL(kernel.function.address)(d, n, *arrays)
    failure = getattr(kernel.function, "failure", None)  # of one that calls Python back
    if failure is not None:
        raise Failed(f"{type(failure).__name__}: {failure}") from failure
    for name, array, copy in zip(_INPUTS, inputs, copies, strict=True):
        if array.tobytes() != copy.tobytes():
            raise Stray(f"writes to {name}, which it may only read")
    for name, array in zip(("forces", "the tangent", "the energy"), outputs, strict=True):
        if np.any(array[:GUARD] != _UNTOUCHED) or np.any(array[-GUARD:] != _UNTOUCHED):
            raise Stray(f"adds to rows of {name} that are not its own")
    forces, tangent, energy = (array[GUARD:-GUARD].copy() for array in outputs)
    return energy, forces, tangent


_INPUTS = (
    "the nodes",
    "its integers",
    "its numbers",
    "the stiffness",
    "the values",
    "the places",
    "the displacements",
    "the velocities",
)


def _guarded(rows: int, before: float) -> Floats:
    array = np.full((rows + 2 * GUARD, LANE_COUNT), _UNTOUCHED)
    array[GUARD : GUARD + rows] = before
    return array
