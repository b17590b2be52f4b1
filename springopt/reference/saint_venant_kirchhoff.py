"""The law of Saint Venant and Kirchhoff: Hooke's, of Green's strain."""

from dataclasses import dataclass

import numpy as np

from springopt.checks import Booleans, Floats
from springopt.reference.law import deformation_gradient, volume_strain


@dataclass(frozen=True)
class SaintVenantKirchhoff:
    """W = lame / 2 (tr E)^2 + shear E : E of Green's strain E = (F^T F - I) / 2.

    Plane strain is the law of two axes as it stands; plane stress too, with the first Lame parameter that makes the
    stress across the plane vanish, since that stress is linear in E.
    """

    lame: float  #: [force / area]
    shear: float  #: [force / area]
    #: In plane stress the square of the stretch across the plane is 1 - this tr E; -inf where there is no such stretch.
    contraction: float = -np.inf

    def is_admissible(self, h: Floats) -> Booleans:
        has_volume = volume_strain(h) > -1.0
        if np.isinf(self.contraction):
            return has_volume
        return has_volume & (self.contraction * np.einsum("...ii", _green(h)) < 1.0)

    def energy(self, h: Floats) -> Floats:
        e = _green(h)
        return self.lame / 2 * np.einsum("...ii", e) ** 2 + self.shear * np.einsum("...ij,...ij", e, e)

    def stress(self, h: Floats) -> Floats:
        return deformation_gradient(h) @ self._second_stress(h)

    def moduli(self, h: Floats) -> Floats:
        f, unit = deformation_gradient(h), np.eye(h.shape[-1])
        return (
            np.einsum("ik,...jl->...ijkl", unit, self._second_stress(h))
            + self.lame * np.einsum("...ij,...kl->...ijkl", f, f)
            + self.shear * np.einsum("...il,...kj->...ijkl", f, f)
            + self.shear * np.einsum("...ik,jl->...ijkl", f @ f.swapaxes(-1, -2), unit)
        )

    def _second_stress(self, h: Floats) -> Floats:
        """Second Piola-Kirchhoff stress, shape (..., d, d)."""
        e = _green(h)
        return self.lame * np.einsum("...kk,ij->...ij", e, np.eye(h.shape[-1])) + 2 * self.shear * e


def _green(h: Floats) -> Floats:
    transposed = h.swapaxes(-1, -2)
    return (h + transposed + transposed @ h) / 2
