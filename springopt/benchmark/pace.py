"""How long the jobs that are left will take, judged by those that have ended."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Iterable

from springopt.benchmark.job import Job
from springopt.benchmark.outcome import Outcome


class Pace:
    """Counts what runs took and what is left; it changes itself because a benchmark has one, from start to end.

    A run is expected to take what the other seeds took on average; where none has ended, what runs on its scene took,
    and else what runs took. How many go on at once is seen from what was done since the beginning, wherever it is done.
    """

    def __init__(self, jobs: Iterable[Job]) -> None:
        self._left = Counter(job.pair for job in jobs)
        self._seconds = Counter[object]()  # of runs, by pair, by scene, and of all
        self._runs = Counter[object]()
        self._work = 0.0  # seconds that the jobs of this call took, added up
        self._began = time.perf_counter()

    def note(self, outcome: Outcome) -> None:
        """A job has ended; a refusal ends all jobs of its pair."""
        pair = outcome.pair
        self._left[pair] = 0 if outcome.state == "refused" else max(0, self._left[pair] - 1)
        for group in (pair, outcome.scene, None):
            self._seconds[group] += max(outcome.took, outcome.seconds or 0.0)  # type: ignore[assignment]
            self._runs[group] += 1
        self._work += outcome.took
        if not self._work:
            self._began = time.perf_counter()  # until now only results of earlier calls were read

    def seconds_left(self) -> float:
        """Seconds on the wall until all jobs have ended."""
        work_left = sum(count * self._expected(pair) for pair, count in self._left.items())
        at_once = self._work / (time.perf_counter() - self._began) if self._work else 1.0
        return work_left / at_once

    def _expected(self, pair: tuple[str, str]) -> float:
        group = next(group for group in (pair, pair[0], None) if self._runs[group])
        return self._seconds[group] / self._runs[group]
