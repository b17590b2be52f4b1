"""The springs: energy k (L - L0)^2 / 2 each, force k (L - L0) along it, and the tangent of that force.

Always present, so the forward solve calls this kernel directly. Elongations are computed without cancellation,
(2 D.du + du.du) / (L + |D|) + (|D| - L0), so that small displacements of stiff springs keep all their digits.
"""

from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from springopt.effects.lanes import fma, load, maximum, splat, sqrt, store
from springopt.lattice import SpringLattice

# A spring with L0 > 0 has no direction at length 0; below this share of L0 it keeps the last one's magnitude, which
# leaves a very negative tangent there: a maximum along every direction, as it should be.
COLLAPSED = 1e-9
TINY = 1e-150  # its square is still a normal number


class Springs(NamedTuple):
    """What kernels read of the springs, whatever the supports."""

    ends: NDArray[np.int64]  # (s, 2)
    rest_vectors: NDArray[np.float64]  # (s, d), from the first end to the second
    lengths: NDArray[np.float64]  # (s,), of the rest vectors
    natural_lengths: NDArray[np.float64]  # (s,), L0
    prestrains: NDArray[np.float64]  # (s,), |D| - L0


def springs_of(lattice: SpringLattice) -> Springs:
    """The springs of a lattice."""
    ends = np.ascontiguousarray(lattice.springs, dtype=np.int64)
    rest_vectors = lattice.nodes[ends[:, 1]] - lattice.nodes[ends[:, 0]]
    lengths = np.sqrt((rest_vectors**2).sum(axis=1))
    natural_lengths = np.ascontiguousarray(lattice.rest_lengths, dtype=np.float64)
    return Springs(ends, rest_vectors, lengths, natural_lengths, _prestrains(lengths, natural_lengths))


def _prestrains(lengths: NDArray[np.float64], natural: NDArray[np.float64]) -> NDArray[np.float64]:
    # A rest length given as the rounded distance is meant as the distance.
    prestrains = lengths - natural
    prestrains[np.abs(prestrains) <= 4e-16 * lengths] = 0.0
    return prestrains


@njit(error_model="numpy")
def elongation(
    displacements: Any,
    i: int,
    j: int,
    rest_vectors: Any,
    spring: int,
    length: float,
    natural: float,
    prestrain: float,
    delta: Any,
) -> Any:
    """(L, L - L0) of one spring between the nodes whose rows begin at i and j; its vector goes into `delta` (d, 8)."""
    growth, square = splat(0.0), splat(0.0)
    for a in range(len(delta)):
        rest = rest_vectors[spring, a]
        du = load(displacements, j + a) - load(displacements, i + a)
        vector = du + rest
        growth = fma(du + 2.0 * rest, du, growth)
        square = fma(vector, vector, square)
        store(delta, a, vector)
    now = sqrt(square)
    if natural == 0.0:
        return now, now
    # With |D| = 0 the sum is 0 only where the growth is 0 too.
    return now, growth / maximum(now + length, splat(TINY)) + prestrain


@njit(error_model="numpy")
def tension_per_length(stiffness: Any, natural: float, length: Any, longer: Any) -> Any:
    """k (L - L0) / L, the force over the length, and the length it was divided by; k itself where L0 is 0."""
    if natural == 0.0:
        return stiffness, maximum(length, splat(TINY))
    length = maximum(length, splat(COLLAPSED * natural))
    return stiffness * longer / length, length


@njit(error_model="numpy")
def add_springs(
    plan: Any, stiffness: Any, displacements: Any, forces: Any, tangent: Any, energy: Any, delta: Any
) -> None:
    """Add energy (1, 8), internal forces (n d, 8) and tangent blocks of all springs, for eight equilibria at once."""
    # Taken out of the plan once: numba counts references at every access.
    d, ends, block_rows, rest_vectors = plan.dimension, plan.ends, plan.block_rows, plan.rest_vectors
    lengths, natural_lengths, prestrains = plan.lengths, plan.natural_lengths, plan.prestrains
    total = load(energy, 0)
    for spring in range(len(ends)):
        i, j = ends[spring, 0] * d, ends[spring, 1] * d
        natural, k = natural_lengths[spring], load(stiffness, spring)
        length, longer = elongation(
            displacements, i, j, rest_vectors, spring, lengths[spring], natural, prestrains[spring], delta
        )
        transverse, length = tension_per_length(k, natural, length, longer)
        axial = (k - transverse) / (length * length)
        total = fma(k * longer, longer * 0.5, total)
        at_i, at_j, at_ij = block_rows[spring, 0], block_rows[spring, 1], block_rows[spring, 2]
        for a in range(d):
            component = load(delta, a)
            force = transverse * component
            store(forces, j + a, load(forces, j + a) + force)
            store(forces, i + a, load(forces, i + a) - force)
            axial_component = axial * component
            for b in range(d):
                entry = axial_component * load(delta, b)
                if a == b:
                    entry = entry + transverse
                k_ab = a * d + b
                if at_i >= 0:
                    store(tangent, at_i + k_ab, load(tangent, at_i + k_ab) + entry)
                if at_j >= 0:
                    store(tangent, at_j + k_ab, load(tangent, at_j + k_ab) + entry)
                if at_ij >= 0:
                    store(tangent, at_ij + k_ab, load(tangent, at_ij + k_ab) - entry)
    store(energy, 0, total)
