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


@njit(error_model="numpy")
def _between(before: Any, after: Any, own: Any) -> tuple[Any, Any]:
    """(the push on a way between two gaps whose work is the energy's change, its derivative by the second one)."""
    zero, one = splat(0.0), splat(1.0)
    deep, deeper = zero - _penetration(before), zero - _penetration(after)
    way, touches = after - before, _touching(after)
    is_way = where_greater(way * way, zero, one, zero)
    divisor = where_greater(is_way, zero, way, one)
    share = where_greater(is_way, zero, (deeper - deep) / divisor, touches)
    bend = where_greater(is_way, zero, (touches - share) / divisor, zero)
    depth = deep + deeper
    return own * depth * share * 0.5, own * (touches * share + depth * bend) * 0.5


@kernel
def add_plane_between(
    d: int, n: int, nodes: Any, integers: Any, numbers: Any, stiffness: Any, values: Any, places: Any,
    u: Any, v: Any, f: Any, k: Any, e: Any,
) -> None:  # fmt: skip
    """The discrete gradient from `v` to `u`, both displacements."""
    ends, bases, forces, tangent, own = rows(u), rows(v), rows(f), rows(k), load(rows(values), 0)
    for number in range(integers[0]):
        row = integers[1 + number] * d
        before, after = splat(numbers[d + number]), splat(numbers[d + number])
        for a in range(d):
            before = fma(splat(numbers[a]), load(bases, row + a), before)
            after = fma(splat(numbers[a]), load(ends, row + a), after)
        if places[number] < 0 or largest(maximum(_penetration(before), _penetration(after))) <= 0.0:
            continue
        push, against = _between(before, after, own)
        for a in range(d):
            add(forces, row + a, push * numbers[a])
            for b in range(d):
                add_to_block(tangent, places[number], d, a, b, against * (numbers[a] * numbers[b]))


@kernel
def add_sphere_between(
    d: int, n: int, nodes: Any, integers: Any, numbers: Any, stiffness: Any, values: Any, places: Any,
    u: Any, v: Any, f: Any, k: Any, e: Any,
) -> None:  # fmt: skip
    """The discrete gradient from `v` to `u`, both displacements; that of the distance is (a + b) / (|a| + |b|)."""
    ends, bases, forces, tangent, own = rows(u), rows(v), rows(f), rows(k), load(rows(values), 0)
    radius, side = numbers[0], numbers[1]
    arms = np.empty((2 * d, LANE_COUNT))
    for number in range(integers[0]):
        row, rest = integers[1 + number] * d, 2 + number * (d + 2)
        squares = splat(0.0), splat(0.0)
        for a in range(d):
            vector = load(bases, row + a) + numbers[rest + a], load(ends, row + a) + numbers[rest + a]
            squares = fma(vector[0], vector[0], squares[0]), fma(vector[1], vector[1], squares[1])
            store(arms, a, vector[0] + vector[1])
            store(arms, d + a, vector[1])
        least = splat(COLLAPSED * radius)
        near, far = maximum(sqrt(squares[0]), least), maximum(sqrt(squares[1]), least)
        before, after = (near + (-radius)) * side, (far + (-radius)) * side
        if places[number] < 0 or largest(maximum(_penetration(before), _penetration(after))) <= 0.0:
            continue
        push, against = _between(before, after, own)
        lengths = near + far
        push = push * side / lengths
        for a in range(d):
            add(forces, row + a, push * load(arms, a))
            for b in range(d):
                along = load(arms, d + b) / far
                entry = load(arms, a) / lengths * along * against - push * load(arms, a) / lengths * along
                add_to_block(tangent, places[number], d, a, b, entry + push if a == b else entry)
