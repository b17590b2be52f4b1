"""Energy, residual and inertia in extended precision, apart from the solver: what the judge believes.

Everything is `numpy.longdouble` (64 binary digits of mantissa on x86, 11 more than a double), and dense.
"""

from dataclasses import dataclass

import numpy as np

EXACT = np.longdouble
EPSILON = np.finfo(EXACT).eps
#: A rest length within this share of the nodes' distance was rounded from it, and is meant as it.
ROUNDED = 4e-16


@dataclass(frozen=True)
class Body:
    """A lattice with its stiffness, loads and supports."""

    springs: np.ndarray  #: (s, 2)
    rest_vectors: np.ndarray  #: (s, d)
    rest_lengths: np.ndarray  #: (s,)
    stiffness: np.ndarray  #: (s,)
    forces: np.ndarray  #: (n, d)
    free: np.ndarray  #: (n d,) bool

    @classmethod
    def of(cls, lattice, stiffness, case, weight=0.0):
        nodes = lattice.nodes.astype(EXACT)
        vectors = nodes[lattice.springs[:, 1]] - nodes[lattice.springs[:, 0]]
        distances = norm(vectors)
        rest = lattice.rest_lengths.astype(EXACT)
        rest = np.where(np.abs(rest - distances) <= ROUNDED * distances, distances, rest)
        forces = case.forces.astype(EXACT) + weight
        return cls(lattice.springs, vectors, rest, np.asarray(stiffness, dtype=EXACT), forces, case.free.ravel())

    def vectors(self, u):
        return self.rest_vectors + u[self.springs[:, 1]] - u[self.springs[:, 0]]

    def elongations(self, u):
        """L - L0, without cancellation where displacements are small."""
        change = u[self.springs[:, 1]] - u[self.springs[:, 0]]
        distances = norm(self.rest_vectors)
        lengths = norm(self.rest_vectors + change)
        growth = ((2 * self.rest_vectors + change) * change).sum(axis=1)
        both = distances + lengths
        return np.where(both > 0, growth / np.where(both > 0, both, 1), 0) + (distances - self.rest_lengths)

    def strain_energy(self, u):
        return 0.5 * (self.stiffness * self.elongations(u) ** 2).sum()

    def energy(self, u):
        """Strain energy less forces . displacements."""
        return self.strain_energy(u) - (self.forces * u).sum()

    def out_of_balance(self, u):
        """Forces less internal forces, shape (n, d); at the supports minus the reactions."""
        vectors = self.vectors(u)
        pull = self._pull(u)[:, None] * vectors
        rest = self.forces.copy()
        np.add.at(rest, self.springs[:, 0], pull)
        np.add.at(rest, self.springs[:, 1], -pull)
        return rest

    def _pull(self, u):
        """Tension over length; 0 where a spring has no direction to pull in."""
        lengths = norm(self.vectors(u))
        shares = self.elongations(u) / np.where(lengths > 0, lengths, np.inf)
        return self.stiffness * np.where(self.rest_lengths == 0, 1, shares)

    def tangent(self, u):
        """Of the free degrees of freedom, shape (f, f)."""
        n, d = u.shape
        vectors = self.vectors(u)
        lengths = norm(vectors)
        directions = vectors / np.where(lengths > 0, lengths, 1)[:, None]
        pull = self._pull(u)
        outer = directions[:, :, None] * directions[:, None, :]
        blocks = pull[:, None, None] * np.eye(d, dtype=EXACT) + (self.stiffness - pull)[:, None, None] * outer
        total = np.zeros((n, n, d, d), dtype=EXACT)
        i, j = self.springs.T
        for a, b, sign in ((i, i, 1), (j, j, 1), (i, j, -1), (j, i, -1)):
            np.add.at(total, (a, b), sign * blocks)
        return total.transpose(0, 2, 1, 3).reshape(n * d, n * d)[np.ix_(self.free, self.free)]

    def force_scale(self, u):
        """The largest of loads, reactions and prestress."""
        rest = self.out_of_balance(u)
        candidates = [np.abs(self.forces).max(initial=0), np.abs(rest.ravel()[~self.free]).max(initial=0)]
        prestress = np.abs(self.stiffness * (norm(self.rest_vectors) - self.rest_lengths)).max(initial=0)
        return max(*candidates, prestress)

    def rounding(self, u):
        """What the last digit of double displacements, in each spring, leaves out of balance."""
        reach = np.abs(u)[self.springs].sum(axis=(1, 2)) + np.abs(norm(self.rest_vectors) - self.rest_lengths)
        at_nodes = np.zeros(len(u), dtype=EXACT)
        for end in range(2):
            np.add.at(at_nodes, self.springs[:, end], self.stiffness * reach)
        return 8 * np.finfo(float).eps * at_nodes.max(initial=0)


def norm(vectors):
    return np.sqrt((vectors * vectors).sum(axis=-1))


@dataclass(frozen=True)
class Factor:
    """L D L^T of a symmetric matrix, and each pivot's error."""

    inverse_lower: np.ndarray  #: L^-1
    pivots: np.ndarray
    errors: np.ndarray  #: what rounding and an unbalanced force can make of a zero pivot

    @property
    def negative_count(self):
        return int((self.pivots < -self.errors).sum())

    @property
    def zero_count(self):
        return int((np.abs(self.pivots) <= self.errors).sum())

    def solve(self, right):
        """The solution that does not move along what has no stiffness."""
        is_zero = np.abs(self.pivots) <= self.errors
        inverse = np.where(is_zero, 0, 1 / np.where(is_zero, 1, self.pivots))
        return self.inverse_lower.T @ (inverse * (self.inverse_lower @ right))


def factorize(matrix, noise):
    """`noise` (f,) bounds the error of each diagonal entry beside rounding, carried to the pivots by rows of L^-1."""
    count = len(matrix)
    rest, inverse = matrix.copy(), np.eye(count, dtype=EXACT)
    pivots, errors = np.zeros(count, dtype=EXACT), np.zeros(count, dtype=EXACT)
    noise = noise + 1000 * EPSILON * np.abs(np.diag(matrix))
    for k in range(count):
        pivots[k], errors[k] = rest[k, k], (inverse[k] ** 2 * noise).sum()
        if abs(pivots[k]) > errors[k]:
            column = rest[k + 1 :, k] / pivots[k]
            rest[k + 1 :, k + 1 :] -= column[:, None] * rest[k, k + 1 :]
            inverse[k + 1 :] -= column[:, None] * inverse[k]
    return Factor(inverse, pivots, errors)


def polish(body, u):
    """(u, factor of the tangent): the equilibrium next to u, to all digits that extended precision has."""
    u = u.astype(EXACT)
    length = max(norm(body.rest_vectors).max(initial=0), body.rest_lengths.max(initial=0), EXACT(1e-300))
    best = None
    for _ in range(12):
        residual = body.out_of_balance(u).ravel()[body.free]
        largest = np.abs(residual).max(initial=0)
        if best is not None and not largest < 0.5 * best[1]:
            break
        factor = factorize(body.tangent(u), np.full(len(residual), largest / length, dtype=EXACT))
        best = (u, largest, factor)
        step = np.zeros(u.size, dtype=EXACT)
        step[body.free] = factor.solve(residual)
        u = u + step.reshape(u.shape)
    return best[0], best[2]
