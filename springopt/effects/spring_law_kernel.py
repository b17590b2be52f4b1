"""What the kernels of the springs' laws share: the elongation of a spring, and what a tension adds to its two nodes.

`integers`: the number of springs s, then the two nodes of each, then what is the law's own. `numbers`: of each spring
its rest vector, the length of that, L0, and the difference of these.
"""

from typing import Any

from numba import carray, njit

from springopt.effects.blocks import add, add_to_block
from springopt.effects.lanes import load, maximum, splat
from springopt.effects.springs import COLLAPSED, TINY, elongation


@njit(error_model="numpy")
def stretch(d: int, spring: int, integers: Any, numbers: Any, displacements: Any, delta: Any) -> Any:
    """(L - L0, L, L0) of one spring, L never 0; its vector goes into `delta` (d, 8)."""
    table = carray(numbers, (integers[0], d + 3))
    natural = table[spring, d + 1]
    i, j = integers[1 + 2 * spring] * d, integers[2 + 2 * spring] * d
    length, longer = elongation(
        displacements, i, j, table, spring, table[spring, d], natural, table[spring, d + 2], delta
    )
    return longer, maximum(length, splat(max(COLLAPSED * natural, TINY))), natural


@njit(error_model="numpy")
def add_tension(
    d: int, spring: int, integers: Any, places: Any, delta: Any, length: Any, tension: Any, slope: Any, f: Any, k: Any
) -> None:
    """Add the forces (n d, 8) of this tension in a spring, and blocks for its slope dT/dL."""
    i, j, place = integers[1 + 2 * spring] * d, integers[2 + 2 * spring] * d, 3 * spring
    transverse = tension / length
    axial = (slope - transverse) / (length * length)
    for a in range(d):
        component = load(delta, a)
        force = transverse * component
        add(f, j + a, force)
        add(f, i + a, force * -1.0)
        axial_component = axial * component
        for b in range(d):
            entry = axial_component * load(delta, b)
            if a == b:
                entry = entry + transverse
            add_to_block(k, places[place], d, a, b, entry)
            add_to_block(k, places[place + 1], d, a, b, entry)
            add_to_block(k, places[place + 2], d, a, b, entry * -1.0)
