"""What springs pull with where all positions are known: per stiffness, so that forces are linear in the stiffness."""

import numpy as np
from numpy.typing import NDArray

from springopt.effects.springs import TINY
from springopt.lattice import SpringLattice

Floats = NDArray[np.float64]


def forces_per_stiffness(lattice: SpringLattice, displacements: Floats, kinematics: str) -> Floats:
    """The force of each spring on its first node over its stiffness [length], shape (c, s, d); on its second, less it.

    At `displacements` (c, n, d). As the engines have it: (L - L0) along the spring, without cancellation, and all of
    its vector where L0 is 0; for linear kinematics the expansion at rest.
    """
    i, j = lattice.springs.T
    rest, du = lattice.nodes[j] - lattice.nodes[i], displacements[:, j] - displacements[:, i]
    length, natural = np.linalg.norm(rest, axis=1), lattice.rest_lengths
    prestrain = length - natural
    prestrain[np.abs(prestrain) <= 4e-16 * length] = 0.0  # as in `plan`
    if kinematics == "linear":
        length = np.maximum(length, TINY)
        transverse = np.where(natural == 0, 1.0, prestrain / length)[:, None]
        along = ((rest * du).sum(axis=2) / length**2)[..., None]
        return transverse * (rest + du) + (1.0 - transverse) * along * rest
    vectors = rest + du
    now = np.maximum(np.linalg.norm(vectors, axis=2), TINY)
    longer = ((2.0 * rest + du) * du).sum(axis=2) / (now + length) + prestrain
    return np.where(natural == 0, 1.0, longer / now)[..., None] * vectors
