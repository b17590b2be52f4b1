"""Which springs no load case sees, and why: what their ends and forces do in each, computed and not guessed.

At an equilibrium K du = -(dF/dk) dk, and dF/dk, the spring's *pull*, is its elongation along its direction, at the ends
that no support takes up. So du vanishes where the spring has its rest length, where supports take up its force at both
ends, or where the ends hang on modes that nothing resists, which are kept at rest. A spring that has its rest length at
this stiffness is looked at again at others: if it has it there too, no load reaches it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from springopt.checks import Booleans, Floats, Integers
from springopt.lattice import SpringLattice
from springopt.load_case import LoadCase
from springopt.objective import Objective

SMALL = 1e-10  # a share of the largest elongation, of a unit vector or of the body that counts as zero
ROUNDING = 8 * np.finfo(float).eps  # of a length
RIGID = 1e-12  # what moves less under a pull than this share of a single spring's answer is kept at rest
OTHERS = 2  # stiffnesses beside the given one
TOLERANCE = 1e-12


@dataclass(frozen=True, eq=False)
class Stretched:
    """The training load cases at one stiffness, and what the springs do there."""

    cases: list[LoadCase]
    positions: Floats  #: shape (c, n, d)
    has_rest_length: Booleans  #: shape (c, s)
    pulls: Floats  #: |dF/dk| where nothing holds the ends [length], exactly 0 where it is rounding, shape (c, s)


def stretch(objective: Objective, stiffness: Floats) -> Stretched:
    """What the springs do at a stiffness, shape (s,)."""
    cases = [case for case in objective.cases if case.role == "train"]
    positions = objective.model.solve(stiffness, cases, TOLERANCE).positions
    spans, elongations = _spans(objective.model.terms.lattice, positions)
    has_rest_length = elongations == 0
    lengths = np.linalg.norm(spans, axis=-1, keepdims=True)
    directions = np.divide(spans, lengths, out=np.zeros_like(spans), where=lengths > 0)
    ends = objective.model.lattice.springs
    free = np.array([case.free[ends] for case in cases])  # (c, s, 2, d)
    taken = np.where(free & (np.abs(directions) > SMALL)[:, :, None], directions[:, :, None], 0.0)
    return Stretched(cases, positions, has_rest_length, np.sqrt((taken**2).sum(axis=(2, 3))) * np.abs(elongations))


def seen(stretched: Stretched, stiffness: Floats, strengths: Floats) -> Booleans:
    """Which load case sees which spring, shape (c, s), from how far it moves the nodes, |du/dk|, shape (c, s)."""
    return (stretched.pulls > 0) & (strengths > RIGID * stretched.pulls / stiffness.max())


def why_unseen(objective: Objective, stiffness: Floats, stretched: Stretched, springs: Sequence[int]) -> list[str]:
    """For each of these springs, which no load case sees, a sentence: why."""
    if not springs:
        return []
    model = objective.model
    others = stiffness * np.random.default_rng(0).uniform(0.9, 1.1, size=(OTHERS, len(stiffness)))
    elsewhere = _spans(model.terms.lattice, model.solve_many(others, stretched.cases, TOLERANCE).positions)[1] == 0
    weights = model.constant_forces()
    equilibria = [
        _Equilibrium(
            case=case,
            loaded=np.any(case.forces + weights, axis=1),
            positions=stretched.positions[number],
            has_rest_length=stretched.has_rest_length[number],
            keeps_it=np.all(elsewhere[:, number], axis=0),
        )
        for number, case in enumerate(stretched.cases)
    ]
    return [_sentence(model.lattice, stiffness > 0, equilibria, spring) for spring in springs]


@dataclass(frozen=True, eq=False)
class _Equilibrium:
    """One load case, and which springs have their rest length at the given stiffness and at others."""

    case: LoadCase
    loaded: Booleans  #: nodes that a force acts on, shape (n,)
    positions: Floats  #: shape (n, d)
    has_rest_length: Booleans  #: shape (s,)
    keeps_it: Booleans  #: shape (s,)


def _sentence(lattice: SpringLattice, present: Booleans, equilibria: list[_Equilibrium], spring: int) -> str:
    """The causes, each with its load cases."""
    names: dict[str, list[str]] = {}
    for equilibrium in equilibria:
        names.setdefault(_cause(lattice, present, equilibrium, spring), []).append(equilibrium.case.name)
    if len(names) == 1:
        return f"{next(iter(names))} in every load case"
    return "; ".join(f"{cause} in {', '.join(cases)}" for cause, cases in names.items())


def _cause(lattice: SpringLattice, present: Booleans, equilibrium: _Equilibrium, spring: int) -> str:
    ends = lattice.springs[spring]
    supports = equilibrium.case.supports[ends]
    if supports.all():
        return "both its ends are held"
    if equilibrium.has_rest_length[spring] or not present[spring]:
        for end, held in zip(ends.tolist(), supports.all(axis=1), strict=True):
            others = np.count_nonzero(present & (lattice.springs == end).any(axis=1)) - present[spring]
            if not (others or held or equilibrium.loaded[end]):
                return f"its node {end} has no other spring and no load"
    if equilibrium.has_rest_length[spring]:
        return _at_rest_length(lattice, present, equilibrium, spring)
    span = np.diff(equilibrium.positions[ends], axis=0)[0]
    if (np.abs(np.where(supports, 0.0, span)) <= SMALL * np.linalg.norm(span)).all():
        return "its ends are held in its direction"
    return "its ends hang on modes that nothing resists"


def _at_rest_length(lattice: SpringLattice, present: Booleans, equilibrium: _Equilibrium, spring: int) -> str:
    if not equilibrium.keeps_it[spring]:
        return "it has its rest length at this stiffness, as by symmetry, and not at others"
    part = _part(lattice.springs[present & equilibrium.has_rest_length], lattice.springs[spring])
    rest, now = lattice.nodes[part], equilibrium.positions[part]
    size = float(np.linalg.norm(np.ptp(lattice.nodes, axis=0)))
    if np.abs(now - rest).max() <= SMALL * size:
        return "its part of the lattice stays at rest"
    if np.abs(_distances(now) - _distances(rest)).max() <= SMALL * size:
        return "its part of the lattice moves as a rigid body"
    return "no load stretches it, whatever the stiffness"


def _spans(lattice: SpringLattice, positions: Floats) -> tuple[Floats, Floats]:
    """Positions (..., n, d) -> vectors of the springs, shape (..., s, d), and elongations, rounding off, (..., s)."""
    spans = positions[..., lattice.springs[:, 1], :] - positions[..., lattice.springs[:, 0], :]
    lengths = np.linalg.norm(spans, axis=-1)
    elongations = lengths - lattice.rest_lengths
    largest = np.abs(elongations).max(axis=-1, keepdims=True)
    zero = np.maximum(SMALL * largest, ROUNDING * np.maximum(lengths, lattice.rest_lengths))
    return spans, np.where(np.abs(elongations) <= zero, 0.0, elongations)


def _part(springs: Integers, start: Integers) -> Integers:
    """The nodes that these springs connect to the two of `start`, itself included."""
    nodes: set[int] = set()
    fresh = set(start.tolist())
    while fresh:
        nodes |= fresh
        touching = springs[np.isin(springs, sorted(fresh)).any(axis=1)]
        fresh = set(touching.ravel().tolist()) - nodes
    return np.array(sorted(nodes))


def _distances(positions: Floats) -> Floats:
    return np.linalg.norm(positions[:, None] - positions[None], axis=-1)
