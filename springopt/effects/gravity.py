"""Gravity: a constant force on every node, or a potential where masses are fitted."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from springopt.checks import Floats, floats, require_finite, require_shape
from springopt.effects.effect import NOT_FITTED, Effect, Kernel
from springopt.effects.node_masses import mass_parameters, node_masses
from springopt.lattice import SpringLattice


@dataclass(frozen=True)
class Gravity(Effect):
    """The weight of the nodes: mass times acceleration."""

    name = "gravity"
    acts_from_outside = True
    is_translation_invariant = False
    is_rotation_invariant = False
    acceleration: Sequence[float]  #: [length / time^2], one number for each axis
    #: Of each node, one number for all or one for each; 1 if nothing is said.
    mass: float | Sequence[float] | None = None
    density: float | None = None  #: [mass / length^d] of the cells, in place of the mass; in 2D the thickness is 1

    def parameters(self, lattice: SpringLattice) -> dict[str, Floats]:
        is_unsaid = self.mass is None and self.density is None
        return mass_parameters(lattice, 1.0 if is_unsaid else self.mass, self.density)

    def constant_forces(self, lattice: SpringLattice, fitted: frozenset[str] = NOT_FITTED) -> Floats | None:
        masses = node_masses(lattice, self.parameters(lattice))
        forces = masses[:, None] * self._acceleration(lattice)
        return None if fitted else forces

    def potential(self, lattice: SpringLattice, fitted: frozenset[str] = NOT_FITTED) -> Kernel | None:
        """Where masses are fitted: the energy -m a . x of each node."""
        if not fitted:
            return None
        # The mass of a node is its share of one of the parameters.
        parameters = self.parameters(lattice)
        count = len(next(iter(parameters.values())))
        units = {name: np.ones(count) for name in parameters}
        shares = node_masses(lattice, units)
        numbers = np.concatenate([self._acceleration(lattice), shares])
        owners = np.arange(lattice.node_count) if count > 1 else np.zeros(lattice.node_count, dtype=np.int64)
        return Kernel(_kernel(), np.zeros((0, 2), dtype=np.int64), owners, numbers)

    def _acceleration(self, lattice: SpringLattice) -> Floats:
        acceleration = require_finite("acceleration", floats("acceleration", self.acceleration))
        return require_shape("acceleration", acceleration, (lattice.dimension,))


def _kernel() -> Any:
    """Compiled where masses are fitted, and nowhere else."""
    from springopt.effects.gravity_kernel import add_weights

    return add_weights
