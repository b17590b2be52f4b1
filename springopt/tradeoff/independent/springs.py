"""Springs written anew, from the formula and in any precision: what judges the compiled kernel must not call it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from springopt.checks import Floats, Integers
from springopt.lattice import SpringLattice

Reals = NDArray[np.floating[Any]]  # of single, double or long double precision

#: A rest length that is the distance of its nodes but for this share is meant as the distance.
AS_MEANT = 4e-16


@dataclass(frozen=True, eq=False)
class Springs:
    """Springs that pull along themselves with k (L - L0), in the precision of their arrays."""

    ends: Integers  #: shape (s, 2)
    rest_vectors: Reals  #: from the first end to the second [length], shape (s, d)
    rest_lengths: Reals  #: L0 [length], shape (s,)
    stiffness: Reals  #: k [force/length], shape (s,)

    @classmethod
    def of(cls, lattice: SpringLattice, stiffness: Floats, precision: Any = np.longdouble) -> Springs:
        """The springs of a lattice, for a stiffness [force/length] of each, shape (s,)."""
        ends = np.asarray(lattice.springs, dtype=np.int64)
        nodes = lattice.nodes.astype(precision)
        vectors = nodes[ends[:, 1]] - nodes[ends[:, 0]]
        distances = np.sqrt((vectors**2).sum(axis=1))
        given = lattice.rest_lengths.astype(precision)
        rest_lengths = np.where(np.abs(given - distances) <= AS_MEANT * distances, distances, given)
        return cls(ends, vectors, rest_lengths, stiffness.astype(precision))

    def forces(self, displacements: Reals) -> Reals:
        """Internal forces dE/du [force] at displacements (n, d), in the same shape."""
        vectors, lengths = self._now(displacements)
        pulls = self._per_length(lengths)[:, None] * vectors
        forces = np.zeros_like(displacements)
        np.subtract.at(forces, self.ends[:, 0], pulls)
        np.add.at(forces, self.ends[:, 1], pulls)
        return forces

    def energy(self, displacements: Reals) -> float:
        """The sum of k (L - L0)^2 / 2 at displacements (n, d)."""
        _, lengths = self._now(displacements)
        return float((self.stiffness * (lengths - self.rest_lengths) ** 2).sum() / 2)

    def blocks(self, displacements: Reals) -> Reals:
        """The derivative of each spring's pull by its vector [force/length], shape (s, d, d)."""
        vectors, lengths = self._now(displacements)
        across = self._per_length(lengths)[:, None, None]
        directions = vectors / np.where(lengths > 0.0, lengths, 1.0)[:, None]
        along = directions[:, :, None] * directions[:, None, :]
        return across * (np.eye(vectors.shape[1]) - along) + self.stiffness[:, None, None] * along

    def _now(self, displacements: Reals) -> tuple[Reals, Reals]:
        """Vectors (s, d) and lengths L (s,)."""
        vectors = self.rest_vectors + displacements[self.ends[:, 1]] - displacements[self.ends[:, 0]]
        return vectors, np.sqrt((vectors**2).sum(axis=1))

    def _per_length(self, lengths: Reals) -> Reals:
        """k (L - L0) / L; where the length is 0 there is no direction to pull in, and k of L0 = 0 alone."""
        shares = np.divide(self.rest_lengths, lengths, out=np.ones_like(lengths), where=lengths > 0.0)
        return self.stiffness * (1.0 - np.where(self.rest_lengths > 0.0, shares, 0.0))
