"""What a reader needs to know of the runs of optimizers, in sentences."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from springopt.analysis.way import Way
from springopt.tradeoff.axes.optimizer.entrants import say_refused
from springopt.tradeoff.axes.optimizer.places import name_of
from springopt.tradeoff.axes.optimizer.runs import Attempt, Raced
from springopt.tradeoff.point import Point

LATE = 5  # times its limit that a run takes to be called late
EXPONENTS = (1, 2, 3, 4, 5, 6)  # of targets, as negative powers of ten


def notes_on(raced: Raced, points: Sequence[Point], way: Way, least: float, refused: Mapping[str, str]) -> list[str]:
    """Of scale and floor, who is first, what limits the errors, and who is left out for which reason."""
    attempts = raced.attempts
    said = [
        f"1 is the objective of {way.start_is}, {way.start:.4g}; 0 is the floor, {way.floor:.6g}"
        f"{' (proven)' if way.proven else ''}.",
        *way.notes,
    ]
    if any(attempt.run for attempt in attempts):
        said.append(_first_below(attempts, way))
    if any((point.errors <= least).any() for point in points):
        said.append(f"Errors are not below {least:.2g}: the forward solve's tolerance can't tell less from zero.")
    if any(attempt.is_cut for attempt in attempts):
        said.append(
            f"Each run was given {raced.limit:.2g} s on the wall: what plans for all of them may be worse on its way "
            "than it would be with fewer."
        )
    slow = {attempt.optimizer for attempt in attempts if attempt.wall > max(LATE * raced.limit, 1.0)}
    if slow:
        said.append(f"Single steps of {', '.join(sorted(slow))} take longer than that, and no clock ends a step.")
    return said + say_refused(refused)


def _first_below(attempts: Sequence[Attempt], way: Way) -> str:
    """Who is there first, by the median of its runs, those that never come counted as such."""
    firsts: dict[str, list[str]] = {}
    for exponent in EXPONENTS:
        times = {name: float(np.median(_arrivals(attempts, name, way, exponent))) for name in _names(attempts)}
        name, seconds = min(times.items(), key=lambda item: item[1])
        share = f"{10.0 ** (2 - exponent):g} %"
        if not np.isfinite(seconds):
            firsts["nobody"] = [share]
            break
        firsts.setdefault(name, []).append(f"{share} ({name_of(seconds)})")
    said = "; ".join(f"{name} below {', '.join(shares)}" for name, shares in firsts.items())
    return f"First by the median of its runs: {said}."


def _arrivals(attempts: Sequence[Attempt], name: str, way: Way, exponent: int) -> list[float]:
    """Processor seconds until each run of an optimizer met a target; inf where it did not."""
    target = way.target(exponent)
    return [
        next((i.processor_seconds for i in attempt.run.history if i.value <= target), np.inf) if attempt.run else np.inf
        for attempt in attempts
        if attempt.optimizer == name
    ]


def _names(attempts: Sequence[Attempt]) -> list[str]:
    return list(dict.fromkeys(attempt.optimizer for attempt in attempts))
