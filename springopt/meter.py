"""What a run has used of its budget, and the best that it found for it."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import NamedTuple

from springopt.budget import Budget
from springopt.checks import Floats
from springopt.errors import BudgetSpent
from springopt.recorder import Answer
from springopt.run import Improvement


class Times(NamedTuple):
    """What a run has taken so far."""

    seconds: float  #: on the wall
    processor_seconds: float
    solving_seconds: float  #: of the processor's, within forward solves and derivatives


class Clock:
    """The times of a run; it can be set, so that they add up over resumes and replay is free."""

    def __init__(self) -> None:
        self.set(Times(0.0, 0.0, 0.0))

    def set(self, times: Times) -> None:
        self._wall_start = time.perf_counter() - times.seconds
        self._processor_start = time.process_time() - times.processor_seconds
        self._solving = times.solving_seconds

    def read(self) -> Times:
        return Times(time.perf_counter() - self._wall_start, time.process_time() - self._processor_start, self._solving)

    @contextmanager
    def solving(self) -> Iterator[None]:
        """What is done within counts as solving."""
        begun = time.process_time()
        try:
            yield
        finally:
            self._solving += time.process_time() - begun


class Meter:
    """Counts what was spent and remembers the best; it changes itself because a run has one, from start to end.

    Attributes:
        evaluations, solves: spent so far.
        best_value, best_point: the lowest value so far and its point, shape (size,); inf and None at first.
        history: each improvement of the best value.
    """

    def __init__(self, budget: Budget, *, solves_each: int) -> None:
        self.budget = budget
        self.clock = Clock()
        self.evaluations = 0
        self.solves = 0
        self.best_value = math.inf
        self.best_point: Floats | None = None
        self.history: list[Improvement] = []
        self._solves_each = solves_each

    @property
    def target_reached(self) -> bool:
        return self.budget.target is not None and self.best_value <= self.budget.target

    @property
    def seconds_left(self) -> float:
        """Seconds left on the wall; inf without such a limit."""
        return math.inf if self.budget.seconds is None else self.budget.seconds - self.clock.read().seconds

    def counted_room(self, cost: int = 1) -> float:
        """Questions at this cost that the counted limits leave, whatever the clock says; inf without such a limit."""
        if self.target_reached:
            return 0
        evaluations, solves = self.budget.evaluations, self.budget.solves
        room = math.inf if evaluations is None else (evaluations - self.evaluations) // cost
        return room if solves is None else min(room, (solves - self.solves) // (cost * self._solves_each))

    def require_room(self, cost: int) -> None:
        if self.counted_room(cost) < 1:
            raise BudgetSpent

    def require_time(self) -> None:
        if self.seconds_left <= 0:
            raise BudgetSpent

    def room(self) -> float:
        """Evaluations left, for an optimizer to read; under a time limit an estimate from the pace so far."""
        seconds_left = self.seconds_left
        if seconds_left <= 0:
            return 0
        if math.isinf(seconds_left) or not self.evaluations:
            return self.counted_room()
        pace = self.evaluations / self.clock.read().seconds
        return min(self.counted_room(), math.ceil(pace * seconds_left))

    def count(self, points: Floats, answers: Sequence[Answer], *, cost: int = 1) -> None:
        """Charges one answer for each of the points, shape (m, size); a value of None had no equilibrium."""
        for point, answer in zip(points, answers, strict=True):
            self.evaluations += cost
            self.solves += cost * answer.solves(self._solves_each)
            if answer.value is not None and answer.value < self.best_value:
                self.best_value = answer.value
                self.best_point = point.copy()
                times = (answer.seconds, answer.processor_seconds)
                self.history.append(Improvement(self.evaluations, self.solves, *times, answer.value))
