"""The compressible neo-Hookean law, in space and plane strain, and condensed to plane stress."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from springopt.checks import Booleans, Floats
from springopt.reference.law import deformation_gradient, volume_strain

#: Newton's method for the stretch across the plane ends here; it takes about five iterations.
MOST_ITERATIONS = 50
#: The change of the logarithm of the squared stretch that counts as none.
CONVERGED = 1e-13


class Volumetric(NamedTuple):
    """A function of the logarithm of the volume ratio, and its first two derivatives [force / area], shape (...)."""

    value: Floats
    slope: Floats
    curvature: Floats


@dataclass(frozen=True)
class _WithShear(ABC):
    """W = shear / 2 (tr C - d) + U(ln J), with C = F^T F and J = det F, of the d axes that the law has."""

    shear: float  #: [force / area]

    def is_admissible(self, h: Floats) -> Booleans:
        return volume_strain(h) > -1.0

    def energy(self, h: Floats) -> Floats:
        # tr C - d = 2 tr h + h : h
        growth = 2 * np.einsum("...ii", h) + np.einsum("...ij,...ij", h, h)
        return self.shear / 2 * growth + self.volumetric(_log_volume(h)).value

    def stress(self, h: Floats) -> Floats:
        f = deformation_gradient(h)
        slope = self.volumetric(_log_volume(h)).slope
        return self.shear * f + slope[..., None, None] * np.linalg.inv(f).swapaxes(-1, -2)

    def moduli(self, h: Floats) -> Floats:
        inverse, unit = np.linalg.inv(deformation_gradient(h)), np.eye(h.shape[-1])
        _, slope, curvature = self.volumetric(_log_volume(h))
        return (
            self.shear * np.einsum("ik,jl->ijkl", unit, unit)
            + np.einsum("...,...ji,...lk->...ijkl", curvature, inverse, inverse)
            - np.einsum("...,...jk,...li->...ijkl", slope, inverse, inverse)
        )

    @abstractmethod
    def volumetric(self, log_volume: Floats) -> Volumetric:
        """U and its derivatives."""


@dataclass(frozen=True)
class NeoHookean(_WithShear):
    """W = shear / 2 (tr C - d - 2 ln J) + lame / 2 (ln J)^2.

    In plane strain the stretch across the plane is 1, which leaves the law of two axes as it stands.
    """

    lame: float  #: Lame's first parameter [force / area]

    def volumetric(self, log_volume: Floats) -> Volumetric:
        return Volumetric(
            log_volume * (self.lame / 2 * log_volume - self.shear),
            self.lame * log_volume - self.shear,
            np.full(log_volume.shape, self.lame),
        )


@dataclass(frozen=True)
class NeoHookeanPlaneStress(_WithShear):
    """The same law of a thin sheet: at each point the stretch across the plane is the one without stress there.

    With its square z, shear (z - 1) + lame ln J = 0, where J is the ratio of areas times sqrt(z). What is left is
    again a function of C and of the ratio of areas, and bears the incompressible Poisson's ratio 0.5.
    """

    poisson: float

    def is_admissible(self, h: Floats) -> Booleans:
        has_area = super().is_admissible(h)
        log_stretch = self._log_squared_stretch(np.log1p(np.where(has_area, volume_strain(h), 0.0)))
        return has_area & np.isfinite(log_stretch)

    def volumetric(self, log_volume: Floats) -> Volumetric:
        x = self._log_squared_stretch(log_volume)
        z, whole = np.exp(x), log_volume + x / 2
        moved = -2 * self.poisson / self._steepness(x)  # the derivative of x
        return Volumetric(self.shear * ((z - 1) * (1 - whole) / 2 - whole), -self.shear * z, -self.shear * z * moved)

    def _log_squared_stretch(self, log_area: Floats) -> Floats:
        """ln z by Newton's method, shape (...), nan where the sheet has no stable thickness (only if nu < 0).

        shear / lame = (1 - 2 nu) / (2 nu), and the equation is multiplied by 2 nu.
        """
        x, change = np.zeros(log_area.shape), np.full(log_area.shape, np.inf)
        for _ in range(MOST_ITERATIONS):
            error = (1 - 2 * self.poisson) * np.expm1(x) + 2 * self.poisson * (log_area + x / 2)
            steepness = self._steepness(x)
            change = np.clip(error / np.where(steepness > 0, steepness, np.nan), -1.0, 1.0)
            x = x - change
            if not (np.abs(change) > CONVERGED * (1 + np.abs(x))).any():
                break
        return np.where(np.abs(change) <= CONVERGED * (1 + np.abs(x)), x, np.nan)

    def _steepness(self, x: Floats) -> Floats:
        return (1 - 2 * self.poisson) * np.exp(x) + self.poisson


def _log_volume(h: Floats) -> Floats:
    return np.log1p(volume_strain(h))
