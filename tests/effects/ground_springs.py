"""A nonlinear effect as a stranger would write it: every node tied to its rest position by a cubic spring."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import carray, cfunc
from numpy.typing import NDArray

from springopt.effects.effect import KERNEL_SIGNATURE, Effect, tangent_block
from springopt.effects.lanes import LANE_COUNT, fma, load, splat, store
from springopt.lattice import SpringLattice


@cfunc(KERNEL_SIGNATURE)
def _add_ground(
    d: int, n: int, nodes: Any, parameters: Any, block_of: Any, first: Any, start: Any, u: Any, f: Any, k: Any, e: Any
) -> None:
    stiffness = parameters[0]
    displacements, forces = carray(u, (n * d, LANE_COUNT)), carray(f, (n * d, LANE_COUNT))
    # The kernel touches diagonal blocks only; the last of them ends the envelope.
    tangent, energy = carray(k, (1 << 40, LANE_COUNT)), carray(e, (1, LANE_COUNT))
    total = load(energy, 0)
    for node in range(n):
        at = tangent_block(block_of, first, start, d, node, node)
        for a in range(d):
            x = load(displacements, node * d + a)
            square = x * x
            total = fma(square * square, splat(0.25 * stiffness), total)
            store(forces, node * d + a, load(forces, node * d + a) + stiffness * (square * x))
            if at >= 0:
                row = at + a * d + a
                store(tangent, row, load(tangent, row) + 3.0 * stiffness * square)
    store(energy, 0, total)


@dataclass(frozen=True)
class GroundSprings(Effect):
    """Energy stiffness * u^4 / 4 for each degree of freedom."""

    stiffness: float

    def kernel(self, dimension: int) -> Any:
        return _add_ground

    def parameters(self, lattice: SpringLattice) -> NDArray[np.float64]:
        return np.array([self.stiffness])
