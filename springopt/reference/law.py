"""What a hyperelastic law answers: energy, stress and moduli of a deformation gradient."""

from typing import Protocol

import numpy as np

from springopt.checks import Booleans, Floats


class Law(Protocol):
    """A law of d axes, 2 or 3, of deformation gradients I + h at any number of points.

    It takes the displacement gradients h, shape (..., d, d), so that small strains do not drown in the 1 of I + h.
    """

    def is_admissible(self, h: Floats) -> Booleans:
        """Where the volume is positive and the law defined, shape (...)."""
        ...

    def energy(self, h: Floats) -> Floats:
        """Strain energy [force / area], shape (...)."""
        ...

    def stress(self, h: Floats) -> Floats:
        """First Piola-Kirchhoff stress [force / area], the derivative of the energy, shape (..., d, d)."""
        ...

    def moduli(self, h: Floats) -> Floats:
        """The derivative of the stress [force / area], shape (..., d, d, d, d)."""
        ...


def deformation_gradient(h: Floats) -> Floats:
    """I + h, shape (..., d, d)."""
    return h + np.eye(h.shape[-1])


def volume_strain(h: Floats) -> Floats:
    """det(I + h) - 1, exact to rounding where h is small, shape (...)."""
    trace = np.einsum("...ii", h)
    minors = (trace**2 - np.einsum("...ij,...ji", h, h)) / 2  # of second order: all that is left in 2D
    return trace + minors + (np.linalg.det(h) if h.shape[-1] == 3 else 0.0)
