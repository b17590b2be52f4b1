"""Damping: dashpots along the springs, and a drag on the nodes; felt in motion only."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from springopt.checks import Floats, floats, require_nonnegative, require_shape
from springopt.effects.effect import Effect, Kernel
from springopt.effects.spring_law import law_kernel
from springopt.lattice import SpringLattice


@dataclass(frozen=True)
class Damping(Effect):
    """A dashpot of the coefficient springs * k along each spring, and the force -nodes * v on each node."""

    name = "damping"
    is_translation_invariant = False  # the drag is not
    is_rotation_invariant = False
    springs: float = 0.0  #: [time], the coefficient of each dashpot over the stiffness of its spring
    nodes: float | Sequence[float] = 0.0  #: [force * time / length], one number for all nodes or one for each

    def parameters(self, lattice: SpringLattice) -> dict[str, Floats]:
        springs = require_nonnegative("springs", require_shape("springs", floats("springs", self.springs), ()))
        nodes = require_nonnegative("nodes", floats("nodes", self.nodes))
        nodes = require_shape("nodes", nodes, (lattice.node_count,)) if nodes.ndim else nodes[None]
        return {"springs": springs[None], "nodes": nodes}

    def dissipation(self, lattice: SpringLattice) -> Kernel | None:
        springs = law_kernel(_kernel(), lattice, np.array([np.ndim(self.nodes)]))
        own = np.arange(lattice.node_count)[:, None].repeat(2, axis=1)
        return Kernel(springs.function, np.concatenate([springs.pairs, own]), springs.integers, springs.numbers)


def _kernel() -> Any:
    from springopt.effects.damping_kernel import add_damping

    return add_damping
