"""Racing: which of many candidates are among the best, without solving every load case of the others.

Load cases are solved stage by stage. Misfits are never negative, so what a candidate costs in those that were solved
bounds its value from below; once that is above enough values that are known, the candidate is dropped. The answer is
that of solving everything, to the bit: a sum of floats never falls when one of its terms rises from zero.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from springopt.checks import Floats, Integers


class Stage(Protocol):
    """Load cases that a race solves together."""

    @property
    def cases(self) -> Integers: ...


class Racing(Protocol):
    """What a race needs of an objective; see `springopt.objective`."""

    @property
    def tolerance(self) -> float: ...
    @property
    def stages(self) -> Sequence[Stage]: ...
    def misfits(
        self, candidates: Floats, stage: Stage | None = None, tolerance: float | None = None
    ) -> tuple[Floats, NDArray[np.int8]]: ...
    def bounds(self, misfits: Floats, codes: NDArray[np.int8]) -> Floats: ...
    def values(self, candidates: Floats, misfits: Floats, codes: NDArray[np.int8]) -> Floats: ...


class Best(NamedTuple):
    """The best of some points and their rivals, as far as they are points."""

    places: Integers  #: in the points that were asked, the best first, shape (k,)
    values: Floats  #: shape (k,)


class Known(NamedTuple):
    """What a race begins with."""

    wanted: int  #: how many of the best are sought
    rivals: Floats  #: values that compete with the candidates', shape (r,)
    kept: float = -math.inf  #: values up to this are never dropped, as those that may reach a target


class Raced(NamedTuple):
    """What came of a race of m candidates."""

    values: Floats  #: inf where dropped, shape (m,)
    codes: NDArray[np.int8]  #: the worst status found, shape (m,)
    solves: Integers  #: equilibria that were sought for each, shape (m,)


def best_of(values: Floats, count: int, rivals: Floats) -> Best:
    """The best of values (m,) and rivals (r,); among equals values come first, in their order."""
    order = np.argsort(np.concatenate([values, rivals]), kind="stable")[:count]
    places = order[order < len(values)]
    return Best(places, values[places])


def pays(candidate_count: int, known: Known) -> bool:
    """Whether a race can be expected to save more than it costs: not where nearly all candidates are among the best.

    Until a candidate can be dropped, as many values must be known as are sought.
    """
    return 2 * _unknown_count(known) <= candidate_count


def solve_all(objective: Racing, candidates: Floats, tolerance: float | None = None) -> Raced:
    """The same without a race: all load cases of all candidates, shape (m, s)."""
    if not len(candidates):
        return Raced(np.empty(0), np.empty(0, dtype=np.int8), np.empty(0, dtype=np.int64))
    misfits, codes = objective.misfits(candidates, tolerance=tolerance)
    solves = np.full(len(candidates), codes.shape[1], dtype=np.int64)
    return Raced(objective.values(candidates, misfits, codes), codes.max(axis=1), solves)


def race(
    objective: Racing, candidates: Floats, known: Known, *, best: float = math.inf, tolerance: float | None = None
) -> Raced:
    """Races candidates, shape (m, s); all values are exact but those of candidates that were dropped.

    Dropped is what is surely neither among the best `wanted`, nor below `best` and all others, nor at most `kept`.
    """
    case_count = sum(len(stage.cases) for stage in objective.stages)
    misfits = np.zeros((len(candidates), case_count))
    codes = np.zeros(misfits.shape, dtype=np.int8)
    solves = np.zeros(len(candidates), dtype=np.int64)
    values = np.full(len(candidates), np.inf)

    def solve(racers: Integers, stage: Stage) -> None:
        at = (racers[:, None], stage.cases)
        misfits[at], codes[at] = objective.misfits(candidates[racers], stage, tolerance)
        solves[racers] += len(stage.cases)

    def finish(racers: Integers, stages: Sequence[Stage]) -> None:
        for stage in stages:
            solve(racers, stage)
        values[racers] = objective.values(candidates[racers], misfits[racers], codes[racers])

    first, *others = objective.stages
    racers = np.arange(len(candidates))
    solve(racers, first)
    if few := _unknown_count(known):  # the most promising give the others something to beat
        order = np.argsort(objective.bounds(misfits, codes), kind="stable")
        finish(np.sort(order[:few]), others)
        racers = np.sort(order[few:])
    limit = max(_limit(known, values), min(best, values.min()), known.kept)
    for stage in others:
        # By what it is not, so that a nan stays and is found out.
        racers = racers[~(objective.bounds(misfits[racers], codes[racers]) > limit)]
        if not len(racers):
            break
        solve(racers, stage)
    finish(racers, [])
    return Raced(values, codes.max(axis=1, initial=0), solves)


def _unknown_count(known: Known) -> int:
    """How many values must become known before any candidate can be dropped."""
    return max(known.wanted - int(np.isfinite(known.rivals).sum()), 0)


def _limit(known: Known, values: Floats) -> float:
    """The value that a candidate must not exceed to be among the best."""
    joined = np.concatenate([values, known.rivals])
    return float(np.partition(joined, known.wanted - 1)[known.wanted - 1]) if known.wanted <= len(joined) else math.inf
