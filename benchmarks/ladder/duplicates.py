"""Coincident nodes and duplicate springs: as good as one node, one spring of the summed stiffness."""

import numpy as np

import springopt as so
from ladder.rung import Rung
from ladder.shapes import pull

FAMILY = "coincident and duplicate"
GRID = so.SpringLattice.grid((3, 4))
STIFFNESS = np.random.default_rng(8).uniform(1, 6, GRID.spring_count)


def rungs():
    for force in ((0.2, 0.1), (-0.3, 0.0), (0.0, 1.0)):
        single = so.Model(GRID).solve(STIFFNESS, [pull(GRID, force)]).positions[0]
        yield duplicate_springs(force, single)
        yield reversed_springs(force, single)
        yield from (tied_nodes(force, single, stiffness) for stiffness in (1.0, 1e3, 1e9))
        yield overlapping_parts(force)


def duplicate_springs(force, single):
    """Every spring three times, a sixth, a third and a half of its stiffness."""
    lattice = so.SpringLattice(GRID.nodes, np.tile(GRID.springs, (3, 1)), np.tile(GRID.rest_lengths, 3))
    stiffness = np.concatenate([STIFFNESS / 6, STIFFNESS / 3, STIFFNESS / 2])
    return Rung(FAMILY, f"every spring thrice, {force}", lattice, stiffness, pull(lattice, force), known=single)


def reversed_springs(force, single):
    """Every spring once more with its ends exchanged, and once more without stiffness."""
    springs = np.vstack([GRID.springs, GRID.springs[:, ::-1], GRID.springs])
    lattice = so.SpringLattice(GRID.nodes, springs, np.tile(GRID.rest_lengths, 3))
    stiffness = np.concatenate([0.25 * STIFFNESS, 0.75 * STIFFNESS, 0 * STIFFNESS])
    return Rung(FAMILY, f"every spring both ways, {force}", lattice, stiffness, pull(lattice, force), known=single)


def tied_nodes(force, single, stiffness):
    """A twin of the far corner, tied to it without rest length; the corner's load pulls at the twin."""
    nodes = np.vstack([GRID.nodes, GRID.nodes[-1:]])
    springs = np.vstack([GRID.springs, [[11, 12]]])
    lattice = so.SpringLattice(nodes, springs, np.append(GRID.rest_lengths, 0.0))
    case = pull(GRID, force)
    forces = np.vstack([case.forces, case.forces[-1:]])
    forces[11] = 0
    case = so.LoadCase("pull", np.append(so.side(GRID, "left"), False), forces)
    known = np.vstack([single, single[-1:] + np.array(force) / stiffness])
    return Rung(
        FAMILY, f"twin tied by {stiffness:g}, {force}", lattice, np.append(STIFFNESS, stiffness), case, known=known
    )


def overlapping_parts(force):
    """The same body twice at the same place, tied nowhere but at the supports: the load halves do the same."""
    lattice = so.SpringLattice(
        np.vstack([GRID.nodes, GRID.nodes]),
        np.vstack([GRID.springs, GRID.springs + 12]),
        np.tile(GRID.rest_lengths, 2),
    )
    half = so.Model(GRID).solve(STIFFNESS / 2, [pull(GRID, np.array(force) / 2)]).positions[0]
    case = pull(lattice, np.array(force) / 2)
    known = np.vstack([half, half])
    return Rung(FAMILY, f"twice the same body, {force}", lattice, np.tile(STIFFNESS / 2, 2), case, known=known)
