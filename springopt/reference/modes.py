"""The modes of a linear body, and how each of them answers a sudden load: in closed form."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from scipy.linalg import eigh

from springopt.checks import Floats

#: Below this product of damping and time the motion of a free mode is given by its series.
SMALL = 1e-3


@dataclass(frozen=True, eq=False)
class Modes:
    """The modes of stiffness and mass, orthonormal in the mass."""

    squares: Floats  #: of the angular frequencies [1 / time^2], ascending, shape (f,)
    shapes: Floats  #: shape (f, modes)

    @classmethod
    def of(cls, stiffness: Floats, mass: Floats, rigid_count: int) -> Self:
        """Of matrices (f, f); so many modes are without strain, which rounding must not hide."""
        squares, shapes = eigh(stiffness, mass)
        squares[:rigid_count] = 0.0
        return cls(squares, shapes)

    def motion(self, loads: Floats, times: Floats, *, mass_damping: float, stiffness_damping: float) -> Floats:
        """Displacements (t, f) at the times under loads (f,) that act from time 0 on, at rest until then."""
        damping = mass_damping + stiffness_damping * self.squares
        return step_response(self.squares, damping, times) * (self.shapes.T @ loads) @ self.shapes.T


def step_response(squares: Floats, damping: Floats, times: Floats) -> Floats:
    """q(t) of q'' + damping q' + square q = 1 from rest, shape (t, modes)."""
    t, is_free = times[:, None], squares == 0
    motion = np.empty((len(times), len(squares)))
    motion[:, is_free] = _free_flight(damping[is_free], t)
    motion[:, ~is_free] = _oscillation(squares[~is_free], damping[~is_free], t)
    return motion


def _oscillation(squares: Floats, damping: Floats, t: Floats) -> Floats:
    """(1 - exp(-c t / 2) (cosh(r t) + c / 2 sinh(r t) / r)) / k, with r imaginary where the damping is below critical.

    Written with the slower of the two decays in front, so that nothing overflows.
    """
    root = np.sqrt((damping**2 / 4 - squares).astype(complex))
    decay = np.exp(-squares / (damping / 2 + root) * t)
    doubled = 2 * root
    sine = np.where(root == 0, t, -np.expm1(-doubled * t) / np.where(root == 0, 1.0, doubled))
    cosine = (1 + np.exp(-doubled * t)) / 2
    return (1 - decay * (cosine + damping / 2 * sine)).real / squares


def _free_flight(damping: Floats, t: Floats) -> Floats:
    """(c t - 1 + exp(-c t)) / c^2, which is t^2 / 2 without damping."""
    z = damping * t
    series = t**2 / 2 * (1 - z / 3 * (1 - z / 4 * (1 - z / 5 * (1 - z / 6))))
    is_small = z < SMALL
    return np.where(is_small, series, (z + np.expm1(-z)) / np.where(is_small, 1.0, damping) ** 2)
