"""Why a spring moves nothing: what its ends and its force do in each load case, computed and not guessed.

At an equilibrium K du = -(dF/dk) dk, and dF/dk is the spring's elongation along its direction, at its two ends. So du
vanishes where the spring has its rest length, where supports take up its force at both ends, or where the ends hang on
modes that nothing resists. A spring that has its rest length at this stiffness is looked at again at others: if it has
it there too, no load reaches it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from springopt.checks import Booleans, Floats, Integers
from springopt.forward.batch import constant_forces
from springopt.lattice import SpringLattice
from springopt.load_case import LoadCase
from springopt.objective import Objective

SMALL = 1e-9  # a share of the largest elongation, or of a unit vector, that counts as zero
ROUNDING = 8 * np.finfo(float).eps  # of a length
OTHERS = 2  # stiffnesses beside the given one
TOLERANCE = 1e-12


@dataclass(frozen=True, eq=False)
class _Equilibrium:
    """One load case at the given stiffness, and which springs keep their rest length there and at others."""

    case: LoadCase
    loaded: Booleans  #: nodes that a force acts on, shape (n,)
    positions: Floats  #: shape (n, d)
    unstretched: Booleans  #: shape (s,)
    always_unstretched: Booleans  #: shape (s,)


def why_unseen(objective: Objective, stiffness: Floats, springs: Sequence[int]) -> list[str]:
    """For each of these springs a sentence: why no training load case sees it at this stiffness, shape (s,)."""
    if not springs:
        return []
    lattice = objective.model.lattice
    equilibria = list(_equilibria(objective, stiffness))
    return [_sentence(lattice, stiffness > 0, equilibria, spring) for spring in springs]


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
    if equilibrium.unstretched[spring] or not present[spring]:
        for end, held in zip(ends.tolist(), supports.all(axis=1), strict=True):
            others = np.count_nonzero(present & (lattice.springs == end).any(axis=1)) - present[spring]
            if not (others or held or equilibrium.loaded[end]):
                return f"its node {end} has no other spring and no load"
    if equilibrium.unstretched[spring]:
        return _unstretched(lattice, present, equilibrium, spring)
    direction = _unit(np.diff(equilibrium.positions[ends], axis=0)[0])
    if (np.abs(np.where(supports, 0.0, direction)) <= SMALL).all():
        return "its ends are held in its direction"
    return "its ends hang on modes that nothing resists"


def _unstretched(lattice: SpringLattice, present: Booleans, equilibrium: _Equilibrium, spring: int) -> str:
    if not equilibrium.always_unstretched[spring]:
        return "it has its rest length at this stiffness, as by symmetry, and not at others"
    part = _part(lattice.springs[present & equilibrium.unstretched], lattice.springs[spring])
    rest, now = lattice.nodes[part], equilibrium.positions[part]
    size = float(np.linalg.norm(np.ptp(lattice.nodes, axis=0)))
    if np.abs(now - rest).max() <= SMALL * size:
        return "its part of the lattice stays at rest"
    if np.abs(_distances(now) - _distances(rest)).max() <= SMALL * size:
        return "its part of the lattice moves as a rigid body"
    return "no load stretches it, whatever the stiffness"


def _equilibria(objective: Objective, stiffness: Floats) -> Iterator[_Equilibrium]:
    """All training load cases that have a weight."""
    assert objective.weights is not None
    weighted = zip(objective.cases, objective.weights, strict=True)
    cases = [case for case, weight in weighted if case.role == "train" and weight > 0]
    rng = np.random.default_rng(0)
    others = stiffness * rng.uniform(0.9, 1.1, size=(OTHERS, len(stiffness)))
    model = objective.model
    positions = model.solve_many(np.vstack([stiffness, others]), cases, TOLERANCE).positions
    unstretched = _has_rest_length(model.lattice, positions)
    weights = constant_forces(model.lattice, model.effects)
    for number, case in enumerate(cases):
        yield _Equilibrium(
            case=case,
            loaded=np.any(case.forces + weights, axis=1),
            positions=positions[0, number],
            unstretched=unstretched[0, number],
            always_unstretched=np.all(unstretched[:, number], axis=0),
        )


def _has_rest_length(lattice: SpringLattice, positions: Floats) -> Booleans:
    """Positions (..., n, d) -> which springs have their rest length, shape (..., s)."""
    spans = positions[..., lattice.springs[:, 1], :] - positions[..., lattice.springs[:, 0], :]
    lengths = np.linalg.norm(spans, axis=-1)
    elongations = np.abs(lengths - lattice.rest_lengths)
    largest = elongations.max(axis=-1, keepdims=True)
    return elongations <= np.maximum(SMALL * largest, ROUNDING * np.maximum(lengths, lattice.rest_lengths))


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


def _unit(span: Floats) -> Floats:
    length = np.linalg.norm(span)
    return span / length if length else span
