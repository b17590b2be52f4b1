"""Stiffening: springs that harden or soften as they are stretched, by a polynomial of their strain."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from springopt.checks import Floats, floats, require_finite, require_shape
from springopt.effects.effect import NOT_FITTED, Effect, Kernel
from springopt.effects.spring_law import law_kernel
from springopt.errors import UserError
from springopt.lattice import SpringLattice


@dataclass(frozen=True)
class Stiffening(Effect):
    """The tension k L0 (e + quadratic e |e| + cubic e^3) at the strain e = (L - L0) / L0, in place of k L0 e.

    Tension and compression are alike. Positive numbers harden, negative ones soften: then the tension has a maximum,
    beyond which the energy falls without end, and loads may have no equilibrium.
    """

    name = "stiffening"
    scales_with_stiffness = True
    quadratic: float = 0.0  #: [1]
    cubic: float = 0.0  #: [1]

    def parameters(self, lattice: SpringLattice) -> dict[str, Floats]:
        require_strains(self.name, lattice)
        given = {"quadratic": self.quadratic, "cubic": self.cubic}
        return {name: require_finite(name, require_shape(name, floats(name, x), ()))[None] for name, x in given.items()}

    def potential(self, lattice: SpringLattice, fitted: frozenset[str] = NOT_FITTED) -> Kernel | None:
        return law_kernel(_kernel(), lattice)


def require_strains(name: str, lattice: SpringLattice) -> None:
    """Refuses springs without a rest length, which have no strain."""
    without = np.flatnonzero(lattice.rest_lengths == 0)
    if len(without):
        raise UserError(
            f"{name} acts on the strain of springs, but spring {without[0]} has the rest length 0 and so no strain; "
            "give it a rest length."
        )


def _kernel() -> Any:
    from springopt.effects.stiffening_kernel import add_stiffening

    return add_stiffening
