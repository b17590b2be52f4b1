"""Which springs the load cases of a scene identify, and how well.

Near a point the residuals r are linear in the unknowns z, with Jacobian J. Noise of standard deviation sigma in every
coordinate of the reference's positions makes the least-squares estimate of z err with covariance sigma^2 (J'J)^-1
(Björck 1996, section 1.1.4). Directions in which J vanishes to rounding are not identified at all, and whatever has a
component along one has an infinite error. A load case of weight w counts as w measurements.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from threadpoolctl import threadpool_limits

from springopt.analysis.point import Point
from springopt.analysis.sensitivity import Sensitivity, sensitivity
from springopt.analysis.unseen import seen, stretch, why_unseen
from springopt.checks import Booleans, Floats, Integers, require_positive
from springopt.errors import UserError
from springopt.scene import Setup

#: A singular value below this share of the largest one counts as zero: equilibria are exact to about 1e-12.
RANK_TOLERANCE = 1e-10
#: So much of a unit vector in the directions that are not identified counts as rounding.
LOOSE = 1e-6
#: The default noise, as a share of the smallest rest length.
NOISE = 1e-3


@dataclass(frozen=True)
class Unseen:
    """A spring whose stiffness moves no node in any load case, to first order."""

    spring: int
    why: str  #: one sentence


@dataclass(frozen=True)
class Shared:
    """Springs of which only some combinations are identified: a change of one can be made up for by the others."""

    springs: list[int]
    free_directions: int  #: how many independent changes leave all positions as they are


@dataclass(frozen=True, eq=False)
class Identifiability:
    """What the training load cases say of each spring, at one point."""

    at: str  #: which point
    noise: float  #: standard deviation of the reference's coordinates [length]
    stiffness: Floats  #: there [force/length], shape (s,)
    standard_errors: Floats  #: of the stiffness [force/length], inf where it is not identified, shape (s,)
    singular_values: Floats  #: of the Jacobian by the unknowns, falling, shape (u,)
    rank: int
    best_case: Integers  #: which training load case sees each spring best, -1 for none, shape (s,)
    unseen: list[Unseen]
    shared: list[Shared]

    @property
    def condition(self) -> float:
        """The largest singular value over the smallest that is not zero; inf where all are."""
        return float(self.singular_values[0] / self.singular_values[self.rank - 1]) if self.rank else np.inf

    @property
    def is_seen(self) -> Booleans:
        """Shape (s,)."""
        seen = np.ones(len(self.stiffness), dtype=bool)
        seen[[each.spring for each in self.unseen]] = False
        return seen


def identify(setup: Setup, point: Point, *, noise: float | None = None) -> Identifiability:
    """What a scene's training load cases identify at a point; see the module's head.

    Args:
        setup: the scene.
        point: where, see `choose_point`.
        noise: of the reference's coordinates [length]; by default `NOISE` times the smallest rest length.
    """
    _require_stiffness_at_rest(setup)
    objective = setup.objective
    noise = NOISE * objective.smallest_rest_length if noise is None else require_positive("noise", noise)
    derivatives = sensitivity(objective, setup.encoding, point)
    spectrum = _spectrum(derivatives.unknowns)
    strengths = _strengths(derivatives, sum(case.role == "train" for case in setup.cases))
    stretched = stretch(objective, derivatives.stiffness)
    is_seen_in = seen(stretched, derivatives.stiffness, strengths)
    is_seen: Booleans = np.any(is_seen_in, axis=0)
    unseen = np.flatnonzero(~is_seen).tolist()
    reasons = why_unseen(objective, derivatives.stiffness, stretched, unseen)
    return Identifiability(
        at=point.said,
        noise=float(noise),
        stiffness=derivatives.stiffness,
        standard_errors=_standard_errors(derivatives.spread, spectrum, noise),
        singular_values=spectrum.values,
        rank=spectrum.rank,
        best_case=np.where(is_seen, (strengths * is_seen_in).argmax(axis=0), -1),
        unseen=[Unseen(spring, why) for spring, why in zip(unseen, reasons, strict=True)],
        shared=_shared(derivatives.spread @ spectrum.free, is_seen),
    )


def _require_stiffness_at_rest(setup: Setup) -> None:
    if setup.encoding.parameter_count:
        raise UserError(
            f"what load cases tell of {', '.join(setup.model.fitted)} is not known here, only what they tell of each "
            "spring; leave encoding.parameters out."
        )
    if any(case.times is not None for case in setup.cases):
        raise UserError(
            "what load cases tell of each spring is known of equilibria only, and these have times; leave them out."
        )


def standard_errors(spread: Floats, jacobian: Floats, noise: float) -> Floats:
    """Of the stiffness, shape (s,), from its derivatives by the unknowns (s, u), and those of the residuals (r, u)."""
    return _standard_errors(spread, _spectrum(jacobian), noise)


@dataclass(frozen=True, eq=False)
class _Spectrum:
    """Singular values of the Jacobian by the unknowns, and its directions."""

    values: Floats  #: falling, shape (u,)
    rank: int
    scaled: Floats  #: the directions that are identified, over their singular values, shape (u, rank)
    free: Floats  #: those that are not, shape (u, u - rank)


def _spectrum(jacobian: Floats) -> _Spectrum:
    rows, columns = jacobian.shape
    with threadpool_limits(1, user_api="blas"):  # on a busy machine more threads wait for each other
        triangle = np.linalg.qr(jacobian, mode="r") if rows > columns else jacobian
        missing = np.zeros((columns - len(triangle), columns))
        _, values, directions = np.linalg.svd(np.vstack([triangle, missing]))
    rank = int(np.count_nonzero(values > RANK_TOLERANCE * values[0]))
    return _Spectrum(values, rank, directions[:rank].T / values[:rank], directions[rank:].T)


def _standard_errors(spread: Floats, spectrum: _Spectrum, noise: float) -> Floats:
    loose = np.linalg.norm(spread @ spectrum.free, axis=1)
    errors = noise * np.linalg.norm(spread @ spectrum.scaled, axis=1)
    return np.where(loose > LOOSE * np.linalg.norm(spread, axis=1), np.inf, errors)


def _strengths(derivatives: Sensitivity, case_count: int) -> Floats:
    """How far each spring moves the nodes of each load case, per unit of stiffness, shape (c, s)."""
    return np.linalg.norm(derivatives.springs.reshape(case_count, -1, len(derivatives.stiffness)), axis=1)


def _shared(loose: Floats, is_seen: Booleans) -> list[Shared]:
    """Groups of seen springs that make up for each other, from the free directions of stiffness, shape (s, f)."""
    sizes = np.linalg.norm(loose, axis=1)
    left, groups = set(np.flatnonzero(is_seen & (sizes > LOOSE)).tolist()), []
    together = np.abs(loose @ loose.T) > LOOSE * np.outer(sizes, sizes)
    while left:
        group, fresh = set(), {min(left)}
        while fresh:
            group |= fresh
            fresh = set(np.flatnonzero(together[sorted(fresh)].any(axis=0)).tolist()) & left - group
        left -= group
        springs = sorted(group)
        groups.append(Shared(springs, int(np.linalg.matrix_rank(loose[springs], tol=LOOSE))))
    return groups
