"""The weight of nodes whose masses are fitted."""

from typing import Any

from springopt.effects.blocks import add, rows
from springopt.effects.compile import kernel
from springopt.effects.lanes import load


@kernel
def add_weights(
    d: int, n: int, nodes: Any, integers: Any, numbers: Any, stiffness: Any, values: Any, places: Any,
    u: Any, v: Any, f: Any, k: Any, e: Any,
) -> None:  # fmt: skip
    """Energy -m a . x; `integers`: which parameter is each node's; `numbers`: a, then each node's share of it."""
    displacements, forces, energy, masses = rows(u), rows(f), rows(e), rows(values)
    for node in range(n):
        mass = load(masses, integers[node]) * numbers[d + node]
        for a in range(d):
            weight = mass * numbers[a]
            row = node * d + a
            add(forces, row, weight * -1.0)
            add(energy, 0, weight * (load(displacements, row) + nodes[row]) * -1.0)
