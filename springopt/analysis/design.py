"""Which load case to add next: the one from which the unknowns gain most.

The information of load cases adds up: J'J / sigma^2, over the rows of all. The box tells something too, of an unknown
that lies anywhere in an interval of width w with variance w^2 / 12; unknowns are counted in units of that root, so that
the information of the box is the identity, and that of all is M = 1 + S'S with S = J diag(w) / (sqrt(12) sigma).

*D-optimal* is the candidate with the largest gain of log det M, the smallest volume of the confidence ellipsoid.
*E-optimal* is the one that leaves the ellipsoid's longest axis shortest, the largest smallest eigenvalue of S'S
(Pukelsheim 1993, chapter 6). As long as there are directions of which the box tells more than the data, the one that
leaves the fewest comes first, and the smallest eigenvalue is that of the others.

Candidates are picked one after the other, each the best beside those before it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_triangular
from threadpoolctl import threadpool_limits

from springopt.analysis.candidates import Candidate
from springopt.analysis.identifiability import standard_errors
from springopt.analysis.point import Point
from springopt.analysis.sensitivity import Sensitivity, by_unknowns, jacobian, objective_of, sensitivity
from springopt.checks import Floats
from springopt.errors import UserError
from springopt.scene import Setup

CRITERIA = ("D", "E")
SAME = 1e-9  # relative difference of scores that is rounding: the first of equal candidates is picked


@dataclass(frozen=True)
class Score:
    """What there is with a candidate."""

    name: str
    gain: float  #: of log det M, by this candidate
    known: int  #: directions of which the data tell more than the box
    smallest: float  #: eigenvalue of S'S among them; 0 where there are none


@dataclass(frozen=True, eq=False)
class Pick:
    """A candidate that was picked, and how all that were left scored then, in their order."""

    candidate: Candidate
    score: Score
    scores: list[Score]
    standard_errors: Floats  #: with it [force/length], inf where a spring is not identified, shape (s,)
    parameter_errors: Floats  #: those of the fitted parameters, shape (f,)


def design(
    setup: Setup, point: Point, candidates: Sequence[Candidate], count: int, *, criterion: str = "D", noise: float
) -> list[Pick]:
    """The next `count` load cases for a scene, the best first.

    Args:
        setup: the scene; its training load cases are there already.
        point: where, see `choose_point`.
        candidates: load cases to choose from.
        count: how many to pick.
        criterion: "D" or "E".
        noise: of the reference's coordinates [length].
    """
    if not 1 <= count <= len(candidates):
        raise UserError(f"of {len(candidates)} candidates 1 to {len(candidates)} can be picked, not {count}.")
    known = sensitivity(setup.objective, setup.encoding, point)
    blocks = _blocks(setup, point, candidates, known)
    units = known.widths / (np.sqrt(12.0) * noise)
    springs = setup.lattice.spring_count
    rows, left, picks = known.unknowns, list(range(len(candidates))), []
    with threadpool_limits(1, user_api="blas"):
        for _ in range(count):
            information = _information(rows * units)
            scores = [_score(candidates[i].case.name, information, blocks[i] * units) for i in left]
            best = _best(scores, criterion)
            chosen = left.pop(best)
            rows = np.vstack([rows, blocks[chosen]])
            errors = standard_errors(known.spread, rows, noise)
            picks.append(Pick(candidates[chosen], scores[best], scores, errors[:springs], errors[springs:]))
    return picks


def _blocks(setup: Setup, point: Point, candidates: Sequence[Candidate], known: Sensitivity) -> Floats:
    """The Jacobian of each candidate, shape (c, n d, u); in motion (c, t n d, u)."""
    objective = objective_of(setup.objective, [candidate.case for candidate in candidates])
    derivatives = by_unknowns(setup.encoding, point, jacobian(objective, known.row, point.said)) * known.units
    return derivatives.reshape(len(candidates), -1, derivatives.shape[1])


@dataclass(frozen=True, eq=False)
class _Information:
    """What there is before a candidate."""

    squares: Floats  #: S'S, shape (u, u)
    root: Floats  #: R with R'R = 1 + S'S, shape (u, u), upper triangle


def _information(scaled: Floats) -> _Information:
    stacked = np.vstack([scaled, np.eye(scaled.shape[1])])
    return _Information(scaled.T @ scaled, np.asarray(np.linalg.qr(stacked, mode="r")))


def _score(name: str, before: _Information, block: Floats) -> Score:
    rows = block[block.any(axis=1)]
    # det(M + B'B) = det(M) det(1 + W'W) with M = R'R and W = R'^-1 B'.
    whitened = solve_triangular(before.root, rows.T, trans="T")
    gain = float(np.linalg.slogdet(np.eye(len(rows)) + whitened.T @ whitened)[1])
    eigenvalues = np.linalg.eigvalsh(before.squares + rows.T @ rows)
    rounding = len(eigenvalues) * np.finfo(float).eps * eigenvalues[-1]
    known = eigenvalues[eigenvalues > max(1.0, rounding)]
    return Score(name, gain, len(known), float(known[0]) if len(known) else 0.0)


def _best(scores: Sequence[Score], criterion: str) -> int:
    """The place of the best score."""
    if criterion == "D":
        numbers = [score.gain for score in scores]
    else:
        most = max(score.known for score in scores)
        numbers = [score.smallest if score.known == most else -np.inf for score in scores]
    highest = max(numbers)
    return next(place for place, number in enumerate(numbers) if number >= highest - SAME * abs(highest))
