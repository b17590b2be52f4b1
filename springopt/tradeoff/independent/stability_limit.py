"""The longest step of explicit central differences: beyond it the fastest vibration grows without bound.

It is 2 / omega (sqrt(1 + zeta^2) - zeta), where velocities lag by half a step behind damping forces (Belytschko, Liu
and Moran 2000, section 6.2), the least over all modes. The damping ratio zeta of a mode is that of its own motion
alone: exact where damping mixes no modes, as what is in proportion to stiffness or masses does not.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.linalg import eigh
from scipy.sparse.linalg import eigsh

from springopt.checks import Floats
from springopt.load_case import LoadCase
from springopt.tradeoff.independent.system import System

DENSE = 2_000  # unknowns up to which all modes are found; the fastest one beyond


@dataclass(frozen=True)
class StabilityLimit:
    """Of one load case, where it begins."""

    step: float  #: [time]; inf where nothing vibrates
    frequency: float  #: omega of the mode that limits it [1 / time]
    damping_ratio: float
    undamped: float  #: the step without damping [time]


def stability_limit(system: System, case: LoadCase) -> StabilityLimit:
    """With the supports of a load case, and displacements as it begins; every free node has a mass."""
    u = np.where(case.free, 0.0, case.prescribed)
    free = np.flatnonzero(case.free.ravel())
    if not len(free):
        return StabilityLimit(np.inf, 0.0, 0.0, np.inf)
    roots = np.sqrt(np.repeat(system.masses, case.free.shape[1])[free])
    scaled = sparse.diags_array(1.0 / roots)
    stiffness = scaled @ system.tangent(u)[free][:, free] @ scaled
    damping = scaled @ system.damping(u)[free][:, free] @ scaled
    squares, modes = _modes(stiffness)
    frequencies = np.sqrt(np.maximum(squares, 0.0))
    rates = np.einsum("im,im->m", modes, damping @ modes)  # 2 zeta omega
    # As 4 / (c + sqrt(c^2 + 4 omega^2)), which does not cancel.
    steps = 4.0 / np.maximum(rates + np.sqrt(rates**2 + 4.0 * frequencies**2), np.finfo(float).tiny)
    least = int(np.argmin(steps))
    frequency = float(frequencies[least])
    if frequency == 0.0 and rates[least] == 0.0:
        return StabilityLimit(np.inf, 0.0, 0.0, np.inf)
    ratio = float(rates[least]) / (2.0 * frequency) if frequency > 0.0 else np.inf
    fastest = float(frequencies.max())
    return StabilityLimit(float(steps[least]), frequency, ratio, 2.0 / fastest if fastest > 0.0 else np.inf)


def _modes(matrix: sparse.sparray) -> tuple[Floats, Floats]:
    """Eigenvalues (k,) and vectors (size, k) of a symmetric matrix, the largest among them."""
    if matrix.shape[0] <= DENSE:
        return eigh(matrix.toarray())
    return eigsh(matrix, k=1, which="LA")
