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
from springopt.model import Model
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
    positions: Floats  #: at all times, of which a load case without times has one, shape (c, t, n, d)
    has_rest_length: Booleans  #: at all times, shape (c, s)
    #: |dF/dk| where nothing holds the ends [length], the largest of any time; exactly 0 where it is rounding, shape
    #: (c, s).
    pulls: Floats


def stretch(objective: Objective, row: Floats) -> Stretched:
    """What the springs do at a stiffness and parameters, shape (s + f,)."""
    cases = [case for case in objective.cases if case.role == "train"]
    lattice = objective.model.terms.lattice
    positions = objective.model.solve(row, cases, TOLERANCE).positions.reshape(len(cases), -1, *lattice.nodes.shape)
    spans, elongations = _spans(lattice, positions)
    has_rest_length = (elongations == 0).all(axis=1)
    lengths = np.linalg.norm(spans, axis=-1, keepdims=True)
    directions = np.divide(spans, lengths, out=np.zeros_like(spans), where=lengths > 0)
    ends = objective.model.lattice.springs
    free = np.array([case.free[ends] for case in cases])[:, None]  # (c, 1, s, 2, d)
    taken = np.where(free & (np.abs(directions) > SMALL)[..., None, :], directions[..., None, :], 0.0)
    pulls = np.sqrt((taken**2).sum(axis=(-2, -1))) * np.abs(elongations)
    return Stretched(cases, positions, has_rest_length, pulls.max(axis=1))


def seen(model: Model, stretched: Stretched, stiffness: Floats, strengths: Floats) -> Booleans:
    """Which load case sees which spring, shape (c, s), from how far it moves the nodes, |du/dk|, shape (c, s)."""
    if _has_law(model):  # a spring pulls with something else than its elongation
        return strengths > RIGID * strengths.max()
    return (stretched.pulls > 0) & (strengths > RIGID * stretched.pulls / stiffness.max())


def why_unseen(objective: Objective, row: Floats, stretched: Stretched, springs: Sequence[int]) -> list[str]:
    """For each of these springs, which no load case sees, a sentence: why."""
    if not springs:
        return []
    model, lattice = objective.model, objective.model.terms.lattice
    stiffness = row[: lattice.spring_count]
    others = stiffness * np.random.default_rng(0).uniform(0.9, 1.1, size=(OTHERS, len(stiffness)))
    rows = np.concatenate([others, np.tile(row[lattice.spring_count :], (OTHERS, 1))], axis=1)
    positions = model.solve_many(rows, stretched.cases, TOLERANCE).positions
    positions = positions.reshape(OTHERS, len(stretched.cases), -1, *lattice.nodes.shape)
    elsewhere = (_spans(lattice, positions)[1] == 0).all(axis=2)
    weights = model.constant_forces()
    equilibria = [
        _Equilibrium(
            case=case,
            loaded=np.any(case.forces + weights, axis=1),
            positions=stretched.positions[number],
            has_rest_length=stretched.has_rest_length[number],
            keeps_it=np.all(elsewhere[:, number], axis=0),
            has_law=_has_law(model),
        )
        for number, case in enumerate(stretched.cases)
    ]
    return [_sentence(lattice, stiffness > 0, equilibria, spring) for spring in springs]


@dataclass(frozen=True, eq=False)
class _Equilibrium:
    """One load case, and which springs have their rest length at the given stiffness and at others.

    Of a motion whatever is said holds at all times.
    """

    case: LoadCase
    loaded: Booleans  #: nodes that a force acts on, shape (n,)
    positions: Floats  #: shape (t, n, d)
    has_rest_length: Booleans  #: shape (s,)
    keeps_it: Booleans  #: shape (s,)
    has_law: bool  #: whether springs pull with something else than their elongation


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
    span = np.diff(equilibrium.positions[:, ends], axis=1)
    if (np.abs(np.where(supports, 0.0, span)) <= SMALL * np.linalg.norm(span, axis=-1, keepdims=True)).all():
        return "its ends are held in its direction"
    if equilibrium.has_law:
        return "its law gives it no force, or its ends hang on modes that nothing resists"
    return "its ends hang on modes that nothing resists"


def _at_rest_length(lattice: SpringLattice, present: Booleans, equilibrium: _Equilibrium, spring: int) -> str:
    if not equilibrium.keeps_it[spring]:
        return "it has its rest length at this stiffness, as by symmetry, and not at others"
    part = _part(lattice.springs[present & equilibrium.has_rest_length], lattice.springs[spring])
    rest, now = lattice.nodes[part], equilibrium.positions[:, part]
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
    return np.linalg.norm(positions[..., :, None, :] - positions[..., None, :, :], axis=-1)


def _has_law(model: Model) -> bool:
    return any(term.effect.scales_with_stiffness for term, _ in model.terms.potentials)
