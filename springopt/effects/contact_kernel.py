"""What a plane and a sphere push nodes with that are beyond them. `integers`: the number of nodes, then the nodes."""

from typing import Any

import numpy as np
from numba import njit

from springopt.effects.blocks import add, add_to_block, rows
from springopt.effects.compile import kernel
from springopt.effects.lanes import LANE_COUNT, fma, largest, load, maximum, splat, sqrt, store, where_greater

# Nearer to the center, in relation to the radius, a node has no direction.
COLLAPSED = 1e-9


@njit(error_model="numpy")
def _penetration(gap: Any) -> Any:
    return where_greater(splat(0.0), gap, gap * -1.0, splat(0.0))


@njit(error_model="numpy")
def _touching(gap: Any) -> Any:
    return where_greater(splat(0.0), gap, splat(1.0), splat(0.0))


@kernel
def add_plane(
    d: int, n: int, nodes: Any, integers: Any, numbers: Any, stiffness: Any, values: Any, places: Any,
    u: Any, v: Any, f: Any, k: Any, e: Any,
) -> None:  # fmt: skip
    """`numbers`: the normal, then the gap of each node at rest."""
    displacements, forces, tangent, energy, own = rows(u), rows(f), rows(k), rows(e), load(rows(values), 0)
    for number in range(integers[0]):
        row = integers[1 + number] * d
        gap = splat(numbers[d + number])
        for a in range(d):
            gap = fma(splat(numbers[a]), load(displacements, row + a), gap)
        depth = _penetration(gap)
        if places[number] < 0 or largest(depth) <= 0.0:
            continue
        push, against = own * depth, own * _touching(gap)
        add(energy, 0, push * depth * 0.5)
        for a in range(d):
            add(forces, row + a, push * (-numbers[a]))
            for b in range(d):
                add_to_block(tangent, places[number], d, a, b, against * (numbers[a] * numbers[b]))


@kernel
def add_sphere(
    d: int, n: int, nodes: Any, integers: Any, numbers: Any, stiffness: Any, values: Any, places: Any,
    u: Any, v: Any, f: Any, k: Any, e: Any,
) -> None:  # fmt: skip
    """`numbers`: radius, 1 for outside or -1; of each node at rest its vector from the center, distance, and gap."""
    displacements, forces, tangent, energy, own = rows(u), rows(f), rows(k), rows(e), load(rows(values), 0)
    radius, side = numbers[0], numbers[1]
    arm = np.empty((d, LANE_COUNT))
    for number in range(integers[0]):
        row, rest = integers[1 + number] * d, 2 + number * (d + 2)
        growth, square = splat(0.0), splat(0.0)
        for a in range(d):
            moved = load(displacements, row + a)
            vector = moved + numbers[rest + a]
            growth = fma(moved + 2.0 * numbers[rest + a], moved, growth)
            square = fma(vector, vector, square)
            store(arm, a, vector)
        distance = maximum(sqrt(square), splat(COLLAPSED * radius))
        gap = (growth / (distance + numbers[rest + d]) + numbers[rest + d + 1]) * side
        depth = _penetration(gap)
        if places[number] < 0 or largest(depth) <= 0.0:
            continue
        push, against = own * depth, own * _touching(gap)
        bend = push * (-side) / distance  # the push turns with the node
        along = (against - bend) / (distance * distance)
        add(energy, 0, push * depth * 0.5)
        for a in range(d):
            add(forces, row + a, bend * load(arm, a))
            for b in range(d):
                entry = along * load(arm, a) * load(arm, b)
                add_to_block(tangent, places[number], d, a, b, entry + bend if a == b else entry)
