"""What springs in compression carry, taken off again."""

from typing import Any

import numpy as np

from springopt.effects.blocks import rows
from springopt.effects.compile import kernel
from springopt.effects.lanes import LANE_COUNT, absolute, largest, load, splat, store, where_greater
from springopt.effects.spring_law_kernel import add_tension, stretch


@kernel
def take_compression_off(
    d: int, n: int, nodes: Any, integers: Any, numbers: Any, stiffness: Any, values: Any, places: Any,
    u: Any, v: Any, f: Any, k: Any, e: Any,
) -> None:  # fmt: skip
    """To the bit what `springs` adds to forces and tangent, the other way."""
    displacements, forces, tangent, energy, springs = rows(u), rows(f), rows(k), rows(e), rows(stiffness)
    delta, total, zero = np.empty((d, LANE_COUNT)), load(rows(e), 0), splat(0.0)
    for spring in range(integers[0]):
        longer, length, _ = stretch(d, spring, integers, numbers, displacements, delta)
        slack = (longer - absolute(longer)) * 0.5
        if largest(slack * -1.0) <= 0.0:
            continue
        own = load(springs, spring)
        total = total - own * slack * (slack * 0.5)
        slope = where_greater(zero, slack, own * -1.0, zero)
        add_tension(d, spring, integers, places, delta, length, own * slack * -1.0, slope, forces, tangent)
    store(energy, 0, total)
