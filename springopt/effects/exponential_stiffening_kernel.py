"""What springs carry beyond k (L - L0) that stiffen exponentially in tension."""

from typing import Any

import numpy as np
from numba import njit

from springopt.effects.blocks import rows
from springopt.effects.compile import kernel
from springopt.effects.lanes import LANE_COUNT, exp, fma, load, maximum, splat, store, where_greater
from springopt.effects.spring_law_kernel import add_tension, stretch

# Below this the power series keeps more digits; that many terms leave an error of 1e-17.
SMALL, TERM_COUNT = 1.0, 19
# No equilibrium is where exp(x) is beyond this; a trial state may be, and its energy is not to be infinite times 0.
LARGEST = 300.0


@njit(error_model="numpy")
def _third_rest(x: Any) -> Any:
    """(exp(x) - 1 - x - x^2 / 2) / x^3 for x >= 0: 1 / 6 + x / 24 + ..."""
    small = where_greater(splat(SMALL), x, x, splat(SMALL))
    series = splat(1.0)
    for number in range(TERM_COUNT, 3, -1):
        series = fma(series, small * (1.0 / number), splat(1.0))
    whole = maximum(x, splat(SMALL))
    capped = where_greater(splat(LARGEST), whole, whole, splat(LARGEST))
    closed = (exp(capped) - 1.0 - whole - whole * whole * 0.5) / (whole * whole * whole)
    return where_greater(splat(SMALL), x, series * (1.0 / 6.0), closed)


@kernel
def add_exponential_stiffening(
    d: int, n: int, nodes: Any, integers: Any, numbers: Any, stiffness: Any, values: Any, places: Any,
    u: Any, v: Any, f: Any, k: Any, e: Any,
) -> None:  # fmt: skip
    """With x = c e > 0 and r the rest above: tension k L0 e (x / 2 + x^2 r), and so on."""
    displacements, forces, tangent, energy, springs = rows(u), rows(f), rows(k), rows(e), rows(stiffness)
    exponent, delta, total = load(rows(values), 0), np.empty((d, LANE_COUNT)), load(rows(e), 0)
    for spring in range(integers[0]):
        longer, length, natural = stretch(d, spring, integers, numbers, displacements, delta)
        longer, own = maximum(longer, splat(0.0)), load(springs, spring)
        x = exponent * longer / natural
        rest = _third_rest(x)
        tension = own * longer * x * fma(x, rest, splat(0.5))
        slope = own * x * fma(x, fma(x, rest, splat(0.5)), splat(1.0))
        total = fma(own * longer, longer * x * rest, total)
        add_tension(d, spring, integers, places, delta, length, tension, slope, forces, tangent)
    store(energy, 0, total)
