"""How an effect that is a law of the springs packs them for its kernel: what it adds to the tension of each."""

from typing import Any

import numpy as np

from springopt.checks import Floats, Integers
from springopt.effects.effect import Kernel
from springopt.effects.springs import springs_of
from springopt.lattice import SpringLattice


def law_kernel(function: Any, lattice: SpringLattice, owners: Integers | None = None) -> Kernel:
    """The kernel as `spring_law_kernel` reads it; `owners` (s,): which parameter is each spring's, if they differ."""
    springs = springs_of(lattice)
    table = np.column_stack([springs.rest_vectors, springs.lengths, springs.natural_lengths, springs.prestrains])
    parts = [np.array([lattice.spring_count]), springs.ends.ravel(), np.zeros(0) if owners is None else owners]
    return Kernel(function, pairs_of_springs(lattice), np.concatenate(parts).astype(np.int64), table.ravel())


def pairs_of_springs(lattice: SpringLattice) -> Integers:
    """The pairs (i, i), (j, j) and (i, j) of each spring, one behind the other, shape (3 s, 2)."""
    return lattice.springs[:, [0, 0, 1, 1, 0, 1]].reshape(-1, 2)


def along_springs(lattice: SpringLattice, displacements: Floats) -> tuple[Floats, Floats, Floats]:
    """(L - L0 and L [length] (s,), unit vectors from first to second end (s, d)) at displacements (n d,)."""
    springs = springs_of(lattice)
    u = displacements.reshape(lattice.nodes.shape)
    du = u[springs.ends[:, 1]] - u[springs.ends[:, 0]]
    vectors = springs.rest_vectors + du
    lengths = np.maximum(np.linalg.norm(vectors, axis=1), np.finfo(float).tiny)
    growth = ((vectors + springs.rest_vectors) * du).sum(axis=1) / (lengths + springs.lengths)
    return growth + springs.prestrains, lengths, vectors / lengths[:, None]
