"""Gravity: a constant force on every node."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from springopt.checks import floats, require_finite, require_nonnegative, require_shape
from springopt.effects.effect import Effect
from springopt.lattice import SpringLattice


@dataclass(frozen=True)
class Gravity(Effect):
    """The weight of the nodes: mass times acceleration."""

    acceleration: Sequence[float]  #: [length / time^2], one number for each axis
    mass: float | Sequence[float] = 1.0  #: of each node, one number for all or one for each

    def constant_forces(self, lattice: SpringLattice) -> NDArray[np.float64]:
        acceleration = require_finite("acceleration", floats("acceleration", self.acceleration))
        require_shape("acceleration", acceleration, (lattice.dimension,))
        mass = require_nonnegative("mass", floats("mass", self.mass))
        if mass.ndim:
            require_shape("mass", mass, (lattice.node_count,))
        return np.broadcast_to(mass, (lattice.node_count,))[:, None] * acceleration
