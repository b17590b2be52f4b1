"""What a rest length of r L0 changes in a spring of rest length L0, where r is fitted."""

from typing import Any

import numpy as np

from springopt.effects.blocks import rows
from springopt.effects.compile import kernel
from springopt.effects.lanes import LANE_COUNT, load, splat, store
from springopt.effects.spring_law_kernel import add_tension, stretch


@kernel
def add_prestress(
    d: int, n: int, nodes: Any, integers: Any, numbers: Any, stiffness: Any, values: Any, places: Any,
    u: Any, v: Any, f: Any, k: Any, e: Any,
) -> None:  # fmt: skip
    """The tension k (1 - r) L0, whatever the length; behind the nodes in `integers`: which r is each spring's."""
    displacements, forces, tangent, energy, springs = rows(u), rows(f), rows(k), rows(e), rows(stiffness)
    scales, delta, total = rows(values), np.empty((d, LANE_COUNT)), load(rows(e), 0)
    owners = 1 + 2 * integers[0]
    for spring in range(integers[0]):
        owner = integers[owners + spring]
        if owner < 0:
            continue
        longer, length, natural = stretch(d, spring, integers, numbers, displacements, delta)
        shorter = (load(scales, owner) - 1.0) * (-1.0 * natural)
        tension = load(springs, spring) * shorter
        total = total + tension * (longer + shorter * 0.5)
        add_tension(d, spring, integers, places, delta, length, tension, splat(0.0), forces, tangent)
    store(energy, 0, total)
