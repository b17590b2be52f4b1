"""Runs of all optimizers in rounds: a seed each, in an order of their own, until each had its share of the time."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from springopt.errors import NotServed, SpringoptError
from springopt.run import Improvement, Run
from springopt.runner import solve
from springopt.scene import Setup
from springopt.tradeoff.axes.optimizer.entrants import Entrant, reason
from springopt.tradeoff.clock import Progress

LEAST_SEEDS = 3
MOST_SEEDS = 9  # of an optimizer that is content long before its time


@dataclass(frozen=True, eq=False)
class Attempt:
    """One optimizer with one seed."""

    optimizer: str
    seed: int
    processor: float  #: seconds, until it was stopped, content or failed
    wall: float
    run: Run | None  #: None where it failed
    is_cut: bool = False  #: whether the clock ended it
    why: str = ""  #: it failed

    def best_at(self, seconds: float) -> Improvement | None:
        """The lowest value that it had after so many seconds of the processor; None before the first answer."""
        found = [] if self.run is None else self.run.history
        number = int(np.searchsorted([each.processor_seconds for each in found], seconds, side="right"))
        return found[number - 1] if number else None


@dataclass(frozen=True, eq=False)
class Raced:
    """What came of all runs."""

    attempts: Sequence[Attempt]
    refused: dict[str, str]  #: why an optimizer that had begun can't serve, by name
    limit: float  #: seconds on the wall that a run had

    def of(self, optimizer: str) -> list[Attempt]:
        return [attempt for attempt in self.attempts if attempt.optimizer == optimizer]


def race(
    setup: Setup, entrants: Sequence[Entrant], *, seed: int, until: float, limit: float, progress: Progress | None
) -> Raced:
    """Runs with a limit of seconds on the wall, in rounds until that time of `time.perf_counter`.

    The first round is always complete. An optimizer that fails does not run again: it would fail again.

    Args:
        seed: of the first round, others count on from there.
    """
    attempts: list[Attempt] = []
    refused: dict[str, str] = {}
    rng = np.random.default_rng(seed)
    left = list(entrants)
    for round_number in range(MOST_SEEDS):
        for number in rng.permutation(len(left)):
            entrant = left[number]
            # One that spends all of its limit begins nothing that it can't end.
            expected = max((a.wall for a in attempts if a.optimizer == entrant.name), default=0.0)
            if round_number and time.perf_counter() + 0.5 * expected >= until:
                continue
            try:
                attempts.append(_attempt(setup, entrant, seed + round_number, limit))
            except NotServed as refusal:
                refused[entrant.name] = reason(refusal)
            if progress:
                words = f"{entrant.name}, seed {seed + round_number}"
                progress(len(attempts), LEAST_SEEDS * len(entrants), words)
        out = {attempt.optimizer for attempt in attempts if attempt.why} | set(refused)
        left = [entrant for entrant in left if entrant.name not in out]
        if time.perf_counter() >= until:
            break
    return Raced(attempts, refused, limit)


def _attempt(setup: Setup, entrant: Entrant, seed: int, limit: float) -> Attempt:
    own = setup.scene.budget
    seconds = min(limit, own.seconds or limit)
    wall, processor = time.perf_counter(), time.process_time()
    try:
        run = solve(
            setup.scene,
            entrant.optimizer,
            seed=seed,
            seconds=seconds,
            evaluations=own.evaluations,
            solves=own.solves,
            setup=setup,
        )
    except NotServed:
        raise
    except SpringoptError as error:
        spent = time.process_time() - processor, time.perf_counter() - wall
        return Attempt(entrant.name, seed, *spent, None, why=str(error))
    if run.why_stopped == "interrupted":
        raise KeyboardInterrupt
    is_cut = run.why_stopped == "budget" and run.seconds >= seconds
    return Attempt(entrant.name, seed, run.processor_seconds, run.seconds, run, is_cut)
