"""The times at which runs are compared, whose names are their own: a later run is asked for the same ones."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from springopt.tradeoff.axes.optimizer.runs import Attempt

STEPS = (1.0, 2.0, 5.0)  # of each decade
CLOSE = 1.25  # a factor between two times that makes one of them needless


def name_of(seconds: float) -> str:
    """As in "20 ms" or "1.5 s"."""
    return f"{seconds:.3g} s" if seconds >= 1.0 else f"{1e3 * seconds:.3g} ms"


def seconds_of(name: str) -> float:
    """What `name_of` says."""
    number, unit = name.split()
    return float(number) * {"s": 1.0, "ms": 1e-3}[unit]


def places_of(attempts: Sequence[Attempt]) -> list[float]:
    """From when all of an optimizer's runs have a value until the first one is stopped, or the last one is content.

    Seconds of the processor. Empty where no run has a value.
    """
    runs = [attempt for attempt in attempts if attempt.run is not None and attempt.run.history]
    if not runs:
        return []
    first = max(attempt.run.history[0].processor_seconds for attempt in runs if attempt.run is not None)
    stopped = [attempt.processor for attempt in runs if attempt.is_cut]
    # The last time is rounded as its name is, and up where a run has nothing before it.
    last = _rounded(min(stopped), np.floor) if stopped else _rounded(max(a.processor for a in runs), np.ceil)
    last = last if last >= first else _rounded(first, np.ceil)
    between = [time for time in _grid(first) if first <= time < last / CLOSE] if first < last else []
    return [*between, last]


def _rounded(seconds: float, to_whole: np.ufunc) -> float:
    """To two digits."""
    unit = 10.0 ** (np.floor(np.log10(seconds)) - 1)
    return seconds_of(name_of(float(to_whole(seconds / unit) * unit)))


def _grid(first: float) -> Iterator[float]:
    decade = int(np.floor(np.log10(first)))
    for exponent in range(decade, decade + 12):
        yield from (step * 10.0**exponent for step in STEPS)


def without_repeats(places: Sequence[float], errors: Iterable[float], *, change: float) -> list[float]:
    """The times at which something has come of the time, and the last one."""
    kept: list[float] = []
    before = np.inf
    for number, (place, error) in enumerate(zip(places, errors, strict=True)):
        if number == len(places) - 1 or not error >= (1 - change) * before:
            kept.append(place)
            before = error
    return kept
