"""A nonlinear effect as a stranger would write it: every node tied to its rest position by a cubic spring."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from springopt.effects.blocks import add, add_to_block, rows
from springopt.effects.compile import kernel
from springopt.effects.effect import Effect, Kernel
from springopt.effects.lanes import load


@kernel
def _add_ground(
    d: int, n: int, nodes: Any, integers: Any, numbers: Any, stiffness: Any, values: Any, places: Any,
    u: Any, v: Any, f: Any, k: Any, e: Any,
) -> None:  # fmt: skip
    displacements, forces, tangent, energy, own = rows(u), rows(f), rows(k), rows(e), load(rows(values), 0)
    for node in range(n):
        for a in range(d):
            x = load(displacements, node * d + a)
            square = x * x
            add(energy, 0, square * square * own * 0.25)
            add(forces, node * d + a, own * square * x)
            add_to_block(tangent, places[node], d, a, a, own * square * 3.0)


@dataclass(frozen=True)
class GroundSprings(Effect):
    """Energy stiffness * u^4 / 4 for each degree of freedom."""

    name = "ground"
    is_translation_invariant = False
    is_rotation_invariant = False
    stiffness: float  #: [force / length^3] of each degree of freedom

    def parameters(self, lattice):
        return {"stiffness": np.array([self.stiffness])}

    def potential(self, lattice, fitted=frozenset()):
        return Kernel(_add_ground, np.arange(lattice.node_count)[:, None].repeat(2, axis=1))
