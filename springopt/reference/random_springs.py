"""A mass-spring reference at random: which springs it has, and how stiff each of them is."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from springopt.checks import Booleans, Floats, Integers, floats, require_positive, require_shape
from springopt.errors import UserError
from springopt.lattice import SpringLattice
from springopt.reference.words import random_words, uniforms

#: What must be left of a unit stiffness against a spring's stretch, by the other springs, for it to be dropped.
REDUNDANT = 1e-6
#: An eigenvalue below this share of the largest one belongs to a motion that stretches no spring.
ZERO = 1e-10
#: Springs that are thinned out with matrices of (s, s): a second or two, and 32 MB.
MOST = 2_000


def random_stiffness(
    lattice: SpringLattice,
    *,
    seed: int,
    stiffness: Sequence[float],
    kept: float = 1.0,
    anisotropy: Sequence[float] | None = None,
) -> Floats:
    """Stiffness [force/length] of each spring, shape (s,), 0 where it was dropped.

    Springs are dropped one by one in a random order, none without which the body could be deformed at no force, until
    the share `kept` is left. Those that stay have a stiffness from the range, times a factor by their direction.

    Args:
        lattice: the springs that there may be.
        seed: of order and stiffness.
        stiffness: the lowest and the highest, which may be equal.
        kept: share of the springs.
        anisotropy: a factor for each axis; a spring's is their mean, weighted by its squared direction cosines.
    """
    low, high = require_positive("stiffness", require_shape("stiffness", floats("stiffness", stiffness), (2,)))
    if low > high:
        raise UserError(f"stiffness should be a range, its lower end first, but is [{low:g}, {high:g}].")
    count = lattice.spring_count
    words = random_words(2 * count, seed)
    drawn = (low + (high - low) * uniforms(words[count:])) * _factors(lattice, anisotropy)
    wanted = round(kept * count)
    if wanted < count:
        drawn[~_kept(lattice, np.argsort(words[:count], kind="stable"), wanted)] = 0.0
    return drawn


def thin_out(matrices: Sequence[Floats], order: ArrayLike, wanted: int) -> Booleans:
    """Which springs (s,) stay when they are dropped in this order until so many are left.

    A spring stays where the others would let the body be deformed at no force: where it carries no self-stress. That
    must hold in none of `matrices`, each the `pulls` of the coordinates that are free, shape (f, s).
    """
    self_stresses = [_onto_self_stresses(matrix) for matrix in matrices]
    present = np.ones(matrices[0].shape[1], dtype=bool)
    for spring in np.asarray(order).tolist():
        if present.sum() <= wanted:
            break
        if min(stresses[spring, spring] for stresses in self_stresses) < REDUNDANT:
            continue
        present[spring] = False
        for stresses in self_stresses:  # what is left has no force in this spring
            stresses -= np.outer(stresses[spring], stresses[spring] / stresses[spring, spring])
    return present


def pulls(lattice: SpringLattice) -> Floats:
    """What a unit force in each spring does to the nodes at rest, shape (n d, s)."""
    i, j = lattice.springs.T
    directions, springs = _directions(lattice), np.arange(lattice.spring_count)
    matrix = np.zeros((*lattice.nodes.shape, lattice.spring_count))
    matrix[i, :, springs] -= directions
    matrix[j, :, springs] += directions
    return matrix.reshape(lattice.nodes.size, -1)


def _kept(lattice: SpringLattice, order: Integers, wanted: int) -> Booleans:
    if lattice.spring_count > MOST:
        raise UserError(f"at most {MOST:,} springs can be thinned out, not {lattice.spring_count:,}; keep them all.")
    present = thin_out([pulls(lattice)], order, wanted)
    left = int(present.sum())
    if left > wanted:
        least = np.ceil(1e3 * left / lattice.spring_count) / 1e3
        raise UserError(
            f"kept leaves {wanted} of {lattice.spring_count} springs, and with fewer than {left} the body is a "
            f"mechanism; keep a share of {least:g} or more."
        )
    return present


def _onto_self_stresses(matrix: Floats) -> Floats:
    """The projection onto the spring forces that are in balance by themselves, shape (s, s)."""
    values, vectors = np.linalg.eigh(matrix @ matrix.T)
    rows = (vectors / np.sqrt(np.where(values > ZERO * values[-1], values, np.inf))).T @ matrix
    return np.eye(matrix.shape[1]) - rows.T @ rows


def _factors(lattice: SpringLattice, anisotropy: Sequence[float] | None) -> Floats:
    if anisotropy is None:
        return np.ones(lattice.spring_count)
    axes = require_shape("anisotropy", floats("anisotropy", anisotropy), (lattice.dimension,))
    require_positive("anisotropy", axes)
    return (_directions(lattice) ** 2 * axes).sum(axis=1)


def _directions(lattice: SpringLattice) -> Floats:
    """Unit vectors from the first node of each spring to the second, shape (s, d)."""
    i, j = lattice.springs.T
    spans = lattice.nodes[j] - lattice.nodes[i]
    lengths = np.sqrt((spans**2).sum(axis=1))
    if not lengths.all():
        spring = int(np.argmin(lengths))
        raise UserError(f"random springs need a direction, and spring {spring} joins two nodes at one place.")
    return spans / lengths[:, None]
