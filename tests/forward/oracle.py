"""Energy, forces and tangent of a mass-spring model, written to be read: what the kernels are tested against."""

import numpy as np


def spring_vectors(lattice, positions):
    return positions[lattice.springs[:, 1]] - positions[lattice.springs[:, 0]]


def energy(lattice, stiffness, positions, forces):
    lengths = np.linalg.norm(spring_vectors(lattice, positions), axis=1)
    return 0.5 * stiffness @ (lengths - lattice.rest_lengths) ** 2 - np.vdot(forces, positions)


def out_of_balance(lattice, stiffness, positions, forces):
    """Forces less internal forces, shape (n, d)."""
    vectors = spring_vectors(lattice, positions)
    lengths = np.linalg.norm(vectors, axis=1)
    safe = np.where(lengths > 0, lengths, 1.0)
    pull = (stiffness * np.where(lattice.rest_lengths > 0, 1 - lattice.rest_lengths / safe, 1.0))[:, None] * vectors
    rest = np.array(forces, dtype=float)
    np.add.at(rest, lattice.springs[:, 0], pull)
    np.add.at(rest, lattice.springs[:, 1], -pull)
    return rest


def tangent(lattice, stiffness, positions):
    """Shape (n d, n d)."""
    d, eye = lattice.dimension, np.eye(lattice.dimension)
    total = np.zeros((positions.size, positions.size))
    for (i, j), k, rest, vector in zip(
        lattice.springs, stiffness, lattice.rest_lengths, spring_vectors(lattice, positions), strict=True
    ):
        if rest == 0:
            block = k * eye
        else:
            length = np.linalg.norm(vector)
            n = vector / length
            block = k * (np.outer(n, n) + (1 - rest / length) * (eye - np.outer(n, n)))
        a, b = slice(i * d, i * d + d), slice(j * d, j * d + d)
        total[a, a] += block
        total[b, b] += block
        total[a, b] -= block
        total[b, a] -= block
    return total


def smallest_eigenvalue(lattice, stiffness, positions, case):
    free = case.free.ravel()
    return np.linalg.eigvalsh(tangent(lattice, stiffness, positions)[np.ix_(free, free)])[0]
