"""Stiffness contrasts from 1 to 1e12: in series, side by side, at random; loads as the softest springs take them."""

import numpy as np

import springopt as so
from ladder.rung import Rung
from ladder.shapes import chain, pull

FAMILY = "stiffness contrasts"
DECADES = range(13)


def rungs():
    yield from (in_series(decade, soft_first) for decade in DECADES for soft_first in (True, False))
    yield from (long_chain(decade) for decade in DECADES[::3])
    yield from (layers(decade, axis) for decade in DECADES[::2] for axis in (0, 1))
    yield from (at_random((4, 4), decade, seed) for decade in DECADES for seed in range(2))
    yield from (at_random((3, 3, 3), decade, 7) for decade in DECADES[::3])


def in_series(decade, soft_first):
    """Two springs in a row under a pull: each stretches by force over stiffness."""
    stiffness = np.array([1.0, 10.0**decade])[:: 1 if soft_first else -1]
    lattice = chain(3)
    case = so.LoadCase("pull", [True, False, False], [[0, 0], [0, 0], [0.5, 0]])
    stretched = np.concatenate([[0], np.cumsum(0.5 / stiffness)])
    known = lattice.nodes + stretched[:, None] * [1, 0]
    name = f"series, 1e{decade}, {'soft' if soft_first else 'stiff'} first"
    return Rung(FAMILY, name, lattice, stiffness, case, known=known, close=1e-9, status="converged")


def long_chain(decade):
    """Eight springs in a slanted row, soft and stiff by turns."""
    direction = np.array([0.6, 0.8])
    lattice = chain(9, direction=direction)
    stiffness = np.where(np.arange(8) % 2, 10.0**decade, 1.0)
    forces = np.zeros((9, 2))
    forces[-1] = 0.2 * direction
    known = lattice.nodes + np.concatenate([[0], np.cumsum(0.2 / stiffness)])[:, None] * direction
    case = so.LoadCase("pull", np.arange(9) == 0, forces)
    return Rung(FAMILY, f"chain of 8, 1e{decade}", lattice, stiffness, case, known=known, close=1e-9)


def layers(decade, axis):
    """A grid whose far half is stiff: across the pull the layers are in series, along it side by side."""
    lattice = so.SpringLattice.grid((5, 5))
    middles = lattice.nodes[lattice.springs].mean(axis=1)
    stiffness = np.where(middles[:, axis] > 2, 10.0**decade, 1.0)
    name = f"layers {'in series' if axis == 0 else 'side by side'}, 1e{decade}"
    return Rung(FAMILY, name, lattice, stiffness, pull(lattice, (0.05, 0.02)))


def at_random(shape, decade, seed):
    """Stiffness of every magnitude in one grid."""
    rng = np.random.default_rng([seed, decade])
    lattice = so.SpringLattice.grid(shape)
    stiffness = 10.0 ** rng.uniform(0, decade, lattice.spring_count)
    stiffness[rng.permutation(lattice.spring_count)[:2]] = 1.0, 10.0**decade
    case = so.LoadCase("random", so.side(lattice, "left"), rng.normal(0, 0.1, lattice.nodes.shape))
    return Rung(FAMILY, f"random {len(shape)}D, 1e{decade}, seed {seed}", lattice, stiffness, case)
