"""Bending: angle springs that keep two arms at the angle they have at rest."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from springopt.cells import require_nodes
from springopt.checks import Floats, Integers, floats, integers, require_nonnegative, require_shape
from springopt.effects.effect import NOT_FITTED, Effect, Kernel
from springopt.errors import UserError
from springopt.lattice import SpringLattice

#: Arms that turn by less [rad] are in line.
IN_LINE = 1e-9


@dataclass(frozen=True)
class Bending(Effect):
    """The energy stiffness / 2 * (turn - turn at rest)^2 of three nodes a, b, c: by how much their way turns at b.

    In 2D the turn has a sign, and differences are taken within half a turn; in 3D it lies between 0 and half a turn.
    In line, turn 0, is regular in both; in 3D arms that are bent at rest have a kink in their energy when they come in
    line, where no direction leads back. Angles are there whether their springs are or not.
    """

    name = "bending"
    stiffness: float | Sequence[float]  #: [force * length / rad^2], one number for all angles or one for each
    #: The nodes (a, b, c) of each angle, the vertex in the middle; by default every two springs that meet at a node in
    #: line.
    triples: Sequence[Sequence[int]] | None = None

    def parameters(self, lattice: SpringLattice) -> dict[str, Floats]:
        stiffness = require_nonnegative("stiffness", floats("stiffness", self.stiffness))
        count = len(self._triples(lattice))
        return {"stiffness": require_shape("stiffness", stiffness, (count,)) if stiffness.ndim else stiffness[None]}

    def potential(self, lattice: SpringLattice, fitted: frozenset[str] = NOT_FITTED) -> Kernel | None:
        triples = self._triples(lattice)
        head = np.array([len(triples), np.ndim(self.stiffness)])
        pairs = triples[:, [0, 0, 1, 1, 2, 2, 0, 1, 1, 2, 0, 2]].reshape(-1, 2)
        turns = _turns(lattice.nodes[triples])
        if lattice.dimension == 2:
            numbers = np.stack([np.cos(turns), np.sin(turns)], axis=1).ravel()
            return Kernel(_plane_kernel(), pairs, np.concatenate([head, triples.ravel()]), numbers)
        return Kernel(_space_kernel(), pairs, np.concatenate([head, triples.ravel()]), turns)

    def _triples(self, lattice: SpringLattice) -> Integers:
        if self.triples is None:
            return lines(lattice)
        triples = require_shape("triples", integers("triples", self.triples), ("t", 3))
        require_nodes("triples", triples, lattice.node_count)
        arms = np.diff(lattice.nodes[triples], axis=1)
        wrong = np.flatnonzero((np.linalg.norm(arms, axis=2) == 0).any(axis=1))
        if len(wrong):
            raise UserError(f"triples[{wrong[0]}] has an arm of no length, and so no angle; name three places.")
        return triples


def lines(lattice: SpringLattice) -> Integers:
    """Every two springs that meet at a node in line, as triples (t, 3) with that node in the middle."""
    ends = np.unique(np.concatenate([lattice.springs, lattice.springs[:, ::-1]]), axis=0)
    arms = lattice.nodes[ends[:, 1]] - lattice.nodes[ends[:, 0]]
    has_length = np.linalg.norm(arms, axis=1) > 0
    ends, arms = ends[has_length], arms[has_length]
    arms /= np.linalg.norm(arms, axis=1)[:, None]
    begins = np.searchsorted(ends[:, 0], np.arange(lattice.node_count + 1))
    found: list[list[int]] = []
    for node in range(lattice.node_count):
        own = slice(begins[node], begins[node + 1])
        gaps = np.linalg.norm(arms[own, None] + arms[None, own], axis=2)
        first, second = np.nonzero(np.triu(gaps <= IN_LINE, k=1))
        found.extend([a, node, c] for a, c in zip(ends[own, 1][first], ends[own, 1][second], strict=True))
    if not found:
        raise UserError("bending acts on springs that meet in line, but no two of this lattice do; name triples.")
    return np.array(found, dtype=np.int64)


def _turns(corners: Floats) -> Floats:
    """The turn of each way (t, 3, d) at its middle [rad], with a sign in 2D; exactly 0 in line."""
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 1]
    if corners.shape[2] == 2:
        sines = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
    else:
        sines = np.linalg.norm(np.cross(first, second), axis=1)
    turns = np.arctan2(sines, (first * second).sum(axis=1))
    return np.where(np.abs(turns) < IN_LINE, 0.0, turns)


def _plane_kernel() -> Any:
    from springopt.effects.bending_kernel import add_plane_angles

    return add_plane_angles


def _space_kernel() -> Any:
    from springopt.effects.bending_kernel import add_space_angles

    return add_space_angles
