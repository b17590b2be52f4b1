"""How a kernel reads and adds to the lane blocks that its pointers lead to."""

from typing import Any

from numba import carray, njit

from springopt.effects.lanes import LANE_COUNT, load, store

_MANY = 1 << 40


@njit(error_model="numpy")
def rows(pointer: Any) -> Any:
    """The lane blocks behind a pointer, as an array (rows, 8) whose length nobody checks."""
    return carray(pointer, (_MANY, LANE_COUNT))


@njit(error_model="numpy")
def add(array: Any, row: int, value: Any) -> None:
    """array[row] += value, a lane block."""
    store(array, row, load(array, row) + value)


@njit(error_model="numpy")
def add_to_block(tangent: Any, place: int, d: int, a: int, b: int, value: Any) -> None:
    """Add dF_ia / du_jb to the block of the nodes i and j at this place; -1 is a block of a held node, and dropped.

    A place is twice the row where the block begins, plus one where the block is stored for j and i.
    """
    if place >= 0:
        entry = b * d + a if place & 1 else a * d + b
        add(tangent, (place >> 1) + entry, value)
