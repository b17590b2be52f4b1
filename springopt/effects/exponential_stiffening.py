"""Exponential stiffening: springs that are the stiffer the longer they are, as soft tissue is."""

from dataclasses import dataclass
from math import factorial
from typing import Any

import numpy as np

from springopt.checks import Floats, floats, require_nonnegative, require_shape
from springopt.effects.effect import NOT_FITTED, Effect, Kernel
from springopt.effects.spring_law import along_springs, law_kernel
from springopt.effects.stiffening import require_strains
from springopt.lattice import SpringLattice

#: Below this the power series of exp(x) keeps more digits than exp(x) less its first terms.
SMALL = 0.1


@dataclass(frozen=True)
class ExponentialStiffening(Effect):
    """The tension k L0 (exp(c e) - 1) / c of springs in tension, at the strain e = (L - L0) / L0 > 0.

    In compression it is k L0 e, as it is without the effect; the stiffness at rest is k on both sides. The law in one
    dimension of Fung (1967), Elasticity of soft tissues in simple elongation, Am. J. Physiol. 213, 1532-1544.
    """

    name = "exponential"
    scales_with_stiffness = True
    is_affine = False
    exponent: float  #: c [1]; 0 is the linear spring

    def parameters(self, lattice: SpringLattice) -> dict[str, Floats]:
        require_strains(self.name, lattice)
        exponent = require_shape("exponent", floats("exponent", self.exponent), ())
        return {"exponent": require_nonnegative("exponent", exponent)[None]}

    def potential(self, lattice: SpringLattice, fitted: frozenset[str] = NOT_FITTED) -> Kernel | None:
        return law_kernel(_kernel(), lattice)

    def force_derivatives(
        self, lattice: SpringLattice, displacements: Floats, *, stiffness: Floats, values: Floats, is_linear: bool
    ) -> Floats:
        """dT/dc = k L0 e^2 (x exp(x) - exp(x) + 1) / x^2 along each spring in tension, x = c e."""
        longer, lengths, along = along_springs(lattice, displacements * (not is_linear))
        strain = np.maximum(longer / lattice.rest_lengths, 0.0)
        x = values[0] * strain
        tension = stiffness * lattice.rest_lengths * strain**2 * _slope_by_exponent(x)
        pulls = tension[:, None] * along
        if is_linear:  # d2T / dc dL = k e exp(x) along the spring, and the tension turns with it
            u = displacements.reshape(lattice.nodes.shape)
            du = u[lattice.springs[:, 1]] - u[lattice.springs[:, 0]]
            grown = (du * along).sum(axis=1)[:, None] * along
            pulls += (stiffness * strain * np.exp(x))[:, None] * grown + (tension / lengths)[:, None] * (du - grown)
        forces = np.zeros(lattice.nodes.shape)
        np.add.at(forces, lattice.springs[:, 1], pulls)
        np.add.at(forces, lattice.springs[:, 0], -pulls)
        return forces.reshape(1, -1)


def _slope_by_exponent(x: Floats) -> Floats:
    """(x exp(x) - exp(x) + 1) / x^2."""
    series = np.polyval([(n - 1) / factorial(n) for n in range(9, 1, -1)], x)
    whole = np.maximum(x, SMALL)
    return np.where(x < SMALL, series, (whole * np.exp(whole) - np.expm1(whole)) / whole**2)


def _kernel() -> Any:
    from springopt.effects.exponential_stiffening_kernel import add_exponential_stiffening

    return add_exponential_stiffening
