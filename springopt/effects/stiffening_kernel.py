"""What springs carry beyond k (L - L0) that harden or soften by a polynomial."""

from typing import Any

import numpy as np

from springopt.effects.blocks import rows
from springopt.effects.compile import kernel
from springopt.effects.lanes import LANE_COUNT, absolute, load, store
from springopt.effects.spring_law_kernel import add_tension, stretch


@kernel
def add_stiffening(
    d: int, n: int, nodes: Any, integers: Any, numbers: Any, stiffness: Any, values: Any, places: Any,
    u: Any, v: Any, f: Any, k: Any, e: Any,
) -> None:  # fmt: skip
    """Tension k L0 (a e |e| + b e^3), the integral of it, and k (2 a |e| + 3 b e^2)."""
    displacements, forces, tangent, energy, springs = rows(u), rows(f), rows(k), rows(e), rows(stiffness)
    quadratic, cubic = load(rows(values), 0), load(rows(values), 1)
    delta, total = np.empty((d, LANE_COUNT)), load(rows(e), 0)
    for spring in range(integers[0]):
        longer, length, natural = stretch(d, spring, integers, numbers, displacements, delta)
        strain = longer / natural
        size, own = absolute(strain), load(springs, spring)
        tension = own * longer * (quadratic * size + cubic * strain * strain)
        slope = own * (quadratic * size * 2.0 + cubic * strain * strain * 3.0)
        total = total + own * longer * longer * (quadratic * size * (1.0 / 3.0) + cubic * strain * strain * 0.25)
        add_tension(d, spring, integers, places, delta, length, tension, slope, forces, tangent)
    store(energy, 0, total)
