"""How long the jobs that are left will take, judged by those that have ended."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable

from springopt.benchmark.job import Job
from springopt.benchmark.outcome import Outcome

Pair = tuple[str, str]  # scene and label


class Pace:
    """Counts what runs took and what is left; it changes itself because a benchmark has one, from start to end.

    A run is expected to take what the other seeds took on average; where none has ended, what runs on its scene took,
    and else what runs took.

    Args:
        jobs: all of them.
        workers: that share them.
    """

    def __init__(self, jobs: Iterable[Job], workers: int) -> None:
        self._left = Counter(job.pair for job in jobs)
        self._workers = workers
        self._seconds: defaultdict[Pair | str | None, list[float]] = defaultdict(lambda: [0.0, 0.0])

    def note(self, outcome: Outcome) -> None:
        """A job has ended; a refusal ends all jobs of its pair."""
        pair = outcome.pair
        self._left[pair] = 0 if outcome.state == "refused" else max(0, self._left[pair] - 1)
        seconds = max(outcome.took, outcome.seconds or 0.0)
        for group in (pair, outcome.scene, None):
            self._seconds[group][0] += seconds
            self._seconds[group][1] += 1

    def seconds_left(self) -> float | None:
        """Seconds on the wall until all jobs have ended; None while nothing is known."""
        if None not in self._seconds:
            return None
        return sum(count * self._expected(pair) for pair, count in self._left.items()) / self._workers

    def _expected(self, pair: Pair) -> float:
        group = next(group for group in (pair, pair[0], None) if group in self._seconds)
        total, count = self._seconds[group]
        return total / count
