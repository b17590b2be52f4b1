"""What each effect of a scene costs, and what leaving it out would change: which one is not worth its time.

The load cases of the scene are solved with everything, and without one effect after the other, round by round, at one
point of the encoding; the share of an effect is what its absence saves of the processor's time, the median of all
rounds and the range of the middle half. So what an effect makes harder for the search counts as its own.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from springopt.analysis.effect_variants import Variant, candidate_at, variants_of
from springopt.analysis.point import Point
from springopt.checks import Floats
from springopt.forward.status import STATUSES, has_equilibrium
from springopt.scene import Setup

Progress = Callable[[int, int | None, str], None]

LEAST_ROUNDS = 7
MOST_ROUNDS = 200
#: Candidates are repeated until a solve takes so long [s]: clocks tick, and lanes are to be full.
SHORTEST = 0.01
MOST_CANDIDATES = 512


@dataclass(frozen=True)
class EffectShare:
    """One effect, or the kinematics, left out."""

    name: str
    #: Of the processor's time that its absence saves, negative where the solve is easier with it; None without answers.
    share: float | None
    share_low: float | None  #: quartiles over the rounds
    share_high: float | None
    #: The largest change of a load case's positions, over the size of its displacements; None where one has no answer.
    change: float | None
    mean_change: float | None  #: the same, its mean over the load cases
    lost: dict[str, str] = field(default_factory=dict)  #: load cases without an answer then, and their status


@dataclass(frozen=True)
class EffectShares:
    """All effects of a scene."""

    seconds: float  #: processor time of one candidate under all load cases, with everything
    rounds: int
    at: str  #: at which point, as in "at the reference's stiffness"
    shares: list[EffectShare]
    left_out: dict[str, str]  #: what can't be left out, and why not
    accuracy: float
    said: list[str]  #: what is below the accuracy, one sentence each


def effect_shares(
    setup: Setup, point: Point, *, accuracy: float, seconds: float, progress: Progress | None = None
) -> EffectShares:
    """Measured for so many seconds, seven rounds at least; `accuracy` is relative to the displacements."""
    whole = Variant("everything", setup.model, candidate_at(setup, point))
    variants, left_out = variants_of(setup, whole)
    known = whole.solve(setup)
    found = {variant.name: variant.solve(setup) for variant in variants}
    lost = {name: _lost(setup, known, answer) for name, answer in found.items()}
    copies = _copies(setup, whole)
    # A search that finds nothing would be timed for its limit.
    timed = [whole, *(variant for variant in variants if not lost[variant.name])]
    rounds = _measure(setup, timed, copies, seconds, progress)
    saved = dict(zip((variant.name for variant in timed), (1.0 - rounds / rounds[:, :1]).T, strict=True))
    shares = [
        EffectShare(name, None, None, None, None, None, lost[name])
        if lost[name]
        else _share(setup, name, known[0], answer[0], saved[name])
        for name, answer in found.items()
    ]
    return EffectShares(
        seconds=float(np.median(rounds[:, 0])) / copies,
        rounds=len(rounds),
        at=point.said,
        shares=shares,
        left_out=left_out,
        accuracy=accuracy,
        said=[_say(share, accuracy) for share in shares if share.change is not None and share.change < accuracy],
    )


def _copies(setup: Setup, whole: Variant) -> int:
    copies = 8
    while copies < MOST_CANDIDATES:
        begin = time.process_time()
        whole.solve(setup, copies)
        if time.process_time() - begin >= SHORTEST:
            return copies
        copies *= 2
    return copies


def _measure(
    setup: Setup, variants: Sequence[Variant], copies: int, seconds: float, progress: Progress | None
) -> Floats:
    """Processor seconds, shape (rounds, variants)."""
    rounds: list[list[float]] = []
    end = time.perf_counter() + seconds
    while len(rounds) < LEAST_ROUNDS or (time.perf_counter() < end and len(rounds) < MOST_ROUNDS):
        row = []
        for variant in variants:
            begin = time.process_time()
            variant.solve(setup, copies)
            row.append(time.process_time() - begin)
        rounds.append(row)
        if progress:
            progress(len(rounds), None, "rounds, each without one effect after the other")
    return np.array(rounds)


def _lost(setup: Setup, known: tuple[Floats, Floats], found: tuple[Floats, Floats]) -> dict[str, str]:
    """The load cases that one of the two has no answer to, and how the second one ended."""
    is_found = has_equilibrium(found[1].astype(np.int8)) & has_equilibrium(known[1].astype(np.int8))
    return {setup.cases[case].name: str(STATUSES[int(found[1][case])]) for case in np.flatnonzero(~is_found)}


def _share(setup: Setup, name: str, known: Floats, found: Floats, saved: Floats) -> EffectShare:
    low, share, high = np.quantile(saved, [0.25, 0.5, 0.75]).tolist()
    sizes = np.linalg.norm(known, axis=1)
    # What does not move at all is measured by a spring.
    sizes = np.where(sizes > 0.0, sizes, setup.objective.smallest_rest_length)
    changes = np.linalg.norm(found - known, axis=1) / sizes
    return EffectShare(name, share, low, high, float(changes.max()), float(changes.mean()))


def _say(share: EffectShare, accuracy: float) -> str:
    is_seen = share.share_low is not None and share.share_low > 0.0
    cost = f"takes {share.share:.0%} of the time" if is_seen else "takes no time that could be measured"
    advice = "small displacements will do" if share.name == "exact kinematics" else "leave it out"
    return f"{share.name} changes positions by {share.change:.2%} and {cost}: below {accuracy:.2%}, so {advice}."
