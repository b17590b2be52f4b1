"""What dashpots and drag take from motion."""

from typing import Any

import numpy as np

from springopt.effects.blocks import add, add_to_block, rows
from springopt.effects.compile import kernel
from springopt.effects.lanes import LANE_COUNT, fma, load, splat, store
from springopt.effects.spring_law_kernel import stretch


@kernel
def add_damping(
    d: int, n: int, nodes: Any, integers: Any, numbers: Any, stiffness: Any, values: Any, places: Any,
    u: Any, v: Any, f: Any, k: Any, e: Any,
) -> None:  # fmt: skip
    """Behind the springs in `integers`: the step in `values` from one node's drag to the next."""
    displacements, velocities, forces, tangent, power = rows(u), rows(v), rows(f), rows(k), rows(e)
    own, springs, delta = rows(values), rows(stiffness), np.empty((d, LANE_COUNT))
    count = integers[0]
    for spring in range(count):
        i, j, place = integers[1 + 2 * spring] * d, integers[2 + 2 * spring] * d, 3 * spring
        _, length, _ = stretch(d, spring, integers, numbers, displacements, delta)
        speed = splat(0.0)  # at which it lengthens
        for a in range(d):
            store(delta, a, load(delta, a) / length)
            speed = fma(load(delta, a), load(velocities, j + a) - load(velocities, i + a), speed)
        coefficient = load(own, 0) * load(springs, spring)
        tension = coefficient * speed
        add(power, 0, tension * speed)
        for a in range(d):
            force = tension * load(delta, a)
            add(forces, j + a, force)
            add(forces, i + a, force * -1.0)
            for b in range(d):
                entry = coefficient * load(delta, a) * load(delta, b)
                add_to_block(tangent, places[place], d, a, b, entry)
                add_to_block(tangent, places[place + 1], d, a, b, entry)
                add_to_block(tangent, places[place + 2], d, a, b, entry * -1.0)
    stride = integers[1 + 2 * count]
    for node in range(n):
        drag = load(own, 1 + node * stride)
        for a in range(d):
            speed = load(velocities, node * d + a)
            add(power, 0, drag * speed * speed)
            add(forces, node * d + a, drag * speed)
            add_to_block(tangent, places[3 * count + node], d, a, a, drag)
