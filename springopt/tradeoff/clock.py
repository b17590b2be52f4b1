"""Honest clocks: processor and wall time of several tasks, warm-up apart, over and over until both are sure.

Every round runs every task once, in an order of its own, so that whatever else the machine does meets all of them
alike. A task leaves when its interval is narrow; all end when the budget is spent.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from springopt.checks import Floats
from springopt.tradeoff.interval import Interval

Progress = Callable[[int, int | None, str], None]  # how many are done, of how many, and a few words

LEAST_ROUNDS = 7  # fewer where the budget is spent, but one
MOST_ROUNDS = 200
NARROW = 0.05  # width of an interval over its median
SHORTEST = 5e-3  # a task is called over and over until that takes so long [s]: clocks tick


@dataclass(frozen=True, eq=False)
class Timing:
    """Seconds of one call of a task."""

    warm_up: float  #: of the first call on the wall: kernels are compiled, plans made, caches filled
    processor: Floats  #: of the calls after it, shape (r,)
    wall: Floats  #: shape (r,)


@dataclass(eq=False)
class _Measured:
    run: Callable[[], Any]
    name: str
    warm_up: float = 0.0
    calls: int = 1  # in one sample
    processor: list[float] = field(default_factory=list)
    wall: list[float] = field(default_factory=list)

    @property
    def is_sure(self) -> bool:
        return len(self.processor) >= LEAST_ROUNDS and Interval.of(self.processor).width <= NARROW

    def begin(self) -> None:
        self.warm_up = _seconds(self.run)[1]
        again = _seconds(self.run)[1]
        if again < 10 * SHORTEST:  # or an interruption would pass for the time of a call
            again = min(again, *(_seconds(self.run)[1] for _ in range(2)))
        self.calls = max(1, round(SHORTEST / max(again, SHORTEST / 1000)))

    def sample(self) -> None:
        processor, wall = _seconds(lambda: [self.run() for _ in range(self.calls)])
        self.processor.append(processor / self.calls)
        self.wall.append(wall / self.calls)


def time_all(
    tasks: Sequence[tuple[str, Callable[[], Any]]], seconds: float, progress: Progress | None = None
) -> list[Timing]:
    """Times tasks, by name, for so many seconds on the wall; each at least once beside its warm-up."""
    end = time.perf_counter() + seconds
    measured = [_Measured(run, name) for name, run in tasks]
    for number, task in enumerate(measured):
        task.begin()
        if progress:
            progress(number + 1, len(measured), f"warm-up: {task.name}")
    rng = np.random.default_rng(0)
    for done in range(MOST_ROUNDS):
        left = [task for task in measured if not task.is_sure]
        for number in rng.permutation(len(left)):
            if left[number].processor and time.perf_counter() >= end:
                continue
            left[number].sample()
        if progress:
            progress(len(measured) - len(left), len(measured), f"settings sure after {done + 1} rounds")
        if not left or time.perf_counter() >= end:
            break
    return [Timing(task.warm_up, np.array(task.processor), np.array(task.wall)) for task in measured]


def _seconds(run: Callable[[], Any]) -> tuple[float, float]:
    """Of the processor, and on the wall."""
    wall, processor = time.perf_counter(), time.process_time()
    run()
    return time.process_time() - processor, time.perf_counter() - wall
