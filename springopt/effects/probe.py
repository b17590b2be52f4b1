"""One kernel by itself, outside any solve: its energy, forces and blocks, at up to any number of states."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from springopt.checks import Floats
from springopt.effects.compile import compiled
from springopt.effects.effect import Effect, Kernel, call_kernel
from springopt.effects.lanes import LANE_COUNT
from springopt.lattice import SpringLattice


@dataclass(frozen=True, eq=False)
class Probe:
    """What a kernel adds at l states; of a dissipation the power in place of the energy."""

    count: int  #: l
    dimension: int
    lanes: tuple[Floats, Floats, Floats]  #: energy, forces and blocks as the kernel has them, (eights, rows, 8) each

    @property
    def energy(self) -> Floats:
        """Shape (l,)."""
        return _states(self.lanes[0], self.count)[:, 0]

    @property
    def forces(self) -> Floats:
        """Internal forces, shape (l, n d)."""
        return _states(self.lanes[1], self.count)

    @property
    def blocks(self) -> Floats:
        """dF_i / du_j of each of its pairs, shape (l, q, d, d)."""
        d, rows = self.dimension, self.lanes[2].shape[1]
        return _states(self.lanes[2], self.count).reshape(self.count, rows // (d * d), d, d)


def probe(
    kernel: Kernel,
    lattice: SpringLattice,
    displacements: Floats,
    *,
    stiffness: Floats,
    values: Floats,
    velocities: Floats | None = None,
) -> Probe:
    """At displacements (l, n d), for stiffness (s,) or (l, s) and values (k,) or (l, k)."""
    count, d, n = len(displacements), lattice.dimension, lattice.node_count
    velocities = np.zeros_like(displacements) if velocities is None else velocities
    stiffness = np.broadcast_to(stiffness, (count, lattice.spring_count))
    values = np.broadcast_to(values, (count, np.shape(values)[-1]))
    read = [_lanes(rows) for rows in (stiffness, values, displacements, velocities)]
    energy, forces, blocks = (
        np.zeros((len(read[0]), rows, LANE_COUNT)) for rows in (1, lattice.nodes.size, len(kernel.pairs) * d * d)
    )
    # Every pair has a block of its own here, stored as it is declared.
    places = 2 * d * d * np.arange(len(kernel.pairs), dtype=np.int64)
    body = (np.ascontiguousarray(lattice.nodes), kernel.integers, kernel.numbers)  # grids have them column by column
    _call(kernel.function.address, d, n, body, places, tuple(read), (forces, blocks, energy))
    kernel.raise_failure()
    return Probe(count, d, (energy, forces, blocks))


def _lanes(states: Floats) -> Floats:
    """States (l, rows), eight side by side, shape (eights, rows, 8); spare lanes repeat the last."""
    eights = -(-len(states) // LANE_COUNT)
    every = np.minimum(np.arange(eights * LANE_COUNT), len(states) - 1)
    return np.ascontiguousarray(states[every].reshape(eights, LANE_COUNT, states.shape[1]).swapaxes(1, 2))


def _states(lanes: Floats, count: int) -> Floats:
    """The way back, shape (l, rows)."""
    return lanes.swapaxes(1, 2).reshape(len(lanes) * LANE_COUNT, lanes.shape[1])[:count]


@compiled
def _call(address: int, d: int, n: int, body: Any, places: Any, read: Any, added: Any) -> None:
    stiffness, values, displacements, velocities = read
    forces, blocks, energy = added
    for eight in range(len(stiffness)):
        lanes = (stiffness[eight], values[eight], places, displacements[eight], velocities[eight])
        call_kernel(address, d, n, body + lanes + (forces[eight], blocks[eight], energy[eight]))


def force_derivatives(
    effect: Effect,
    kernel: Kernel,
    lattice: SpringLattice,
    displacements: Floats,
    *,
    stiffness: Floats,
    values: Floats,
    is_linear: bool,
) -> Floats:
    """The derivative of a potential's internal forces by its parameters (k,), shape (k, n d), at displacements (n d,).

    Forces are linear in the parameters but for a constant, unless the effect says otherwise; so units tell all. For
    small displacements those of the expansion at rest are meant.
    """
    if not effect.is_affine:
        return effect.force_derivatives(lattice, displacements, stiffness=stiffness, values=values, is_linear=is_linear)
    units = np.concatenate([np.zeros((1, len(values))), np.eye(len(values))])
    states = np.broadcast_to(displacements, (len(units), len(displacements)))
    forces = forces_of(kernel, lattice, states, stiffness=stiffness, values=units, is_linear=is_linear)
    return forces[1:] - forces[0]


def pulls_of_law(
    effect: Effect,
    lattice: SpringLattice,
    displacements: Floats,
    *,
    values: Floats,
    fitted: frozenset[str],
    is_linear: bool,
) -> Floats:
    """What each spring's law adds to the force on its first node, over its stiffness [length], shape (c, s, d).

    The springs are taken apart, each with two nodes of its own, and the kernel is called for those; displacements
    (c, n d).
    """
    d, count = lattice.dimension, lattice.spring_count
    apart = SpringLattice(
        lattice.nodes[lattice.springs].reshape(-1, d),
        np.arange(2 * count).reshape(count, 2),
        lattice.rest_lengths,
    )
    if lattice.cells is not None:
        vars(apart)["boundary"] = lattice.boundary  # known of the whole only
    kernel = _apart(effect, apart, fitted)
    at_ends = displacements.reshape(len(displacements), -1, d)[:, lattice.springs].reshape(len(displacements), -1)
    forces = forces_of(kernel, apart, at_ends, stiffness=np.ones(count), values=values, is_linear=is_linear)
    return -forces.reshape(len(displacements), count, 2, d)[:, :, 0]


def _apart(effect: Effect, lattice: SpringLattice, fitted: frozenset[str]) -> Kernel:
    kernel = effect.potential(lattice, fitted)
    assert kernel is not None  # a law of the springs is a potential
    return kernel


def forces_of(
    kernel: Kernel, lattice: SpringLattice, displacements: Floats, *, stiffness: Floats, values: Floats, is_linear: bool
) -> Floats:
    """Internal forces at displacements (l, n d), shape (l, n d); for small ones those of the expansion at rest."""
    if not is_linear:
        return probe(kernel, lattice, displacements, stiffness=stiffness, values=values).forces
    rest = probe(kernel, lattice, np.zeros_like(displacements), stiffness=stiffness, values=values)
    return rest.forces + times_blocks(kernel, rest.blocks, displacements, lattice.dimension)


def times_blocks(kernel: Kernel, blocks: Floats, vectors: Floats, d: int) -> Floats:
    """The matrix that symmetric blocks (l, q, d, d) of pairs (i, j) stand for, times vectors (l, n d)."""
    by_node = vectors.reshape(len(vectors), -1, d)
    product = np.zeros_like(by_node)
    i, j = kernel.pairs.T
    for number in range(len(vectors)):
        np.add.at(product[number], i, np.einsum("qab,qb->qa", blocks[number], by_node[number, j]))
        off = i != j
        mirrored = np.einsum("qab,qa->qb", blocks[number, off], by_node[number, i[off]])
        np.add.at(product[number], j[off], mirrored)
    return product.reshape(vectors.shape)
