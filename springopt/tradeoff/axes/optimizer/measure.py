"""From the runs of all optimizers to points of what is left over what was spent."""

from __future__ import annotations

import time
from collections.abc import Iterable, Sequence

import numpy as np

from springopt.analysis.way import Way
from springopt.checks import Floats
from springopt.scene import Scene, Setup
from springopt.tradeoff.axes.optimizer.entrants import Entrant, entrants_of
from springopt.tradeoff.axes.optimizer.places import name_of, places_of, seconds_of, without_repeats
from springopt.tradeoff.axes.optimizer.records import overhead_of, record_of
from springopt.tradeoff.axes.optimizer.runs import LEAST_SEEDS, Attempt, race
from springopt.tradeoff.axes.optimizer.said import notes_on
from springopt.tradeoff.axes.optimizer.scale import resolution, way_of
from springopt.tradeoff.point import Findings, Point, Request

WORTH = 0.05  # a gain of the median error that is worth a point
LEAST_SHARE = 0.25  # of the seconds: what warm-ups leave at least for runs
SHORTEST = 0.05  # seconds of a run


def measure(setup: Setup, request: Request) -> Findings:
    """Every optimizer with several seeds; see `entrants`, `runs`, `scale` and `places`."""
    begun = time.perf_counter()
    wanted = {series for series, _ in request.only}
    entrants, refused = entrants_of(setup, wanted, request.progress)
    left = max(request.seconds - (time.perf_counter() - begun), LEAST_SHARE * request.seconds)
    raced = race(
        setup,
        entrants,
        seed=request.seed,
        until=time.perf_counter() + left,
        limit=_limit(request, left, len(entrants)),
        progress=request.progress,
    )
    refused |= raced.refused
    way = way_of(setup, raced.attempts, request.before.get("floor", np.inf))
    least = resolution(setup, way)
    points: list[Point] = []
    for entrant in entrants:
        points += _points(setup.scene, entrant, raced.of(entrant.name), way, least, request)
    numbers = {
        "start": way.start,
        "start_is": way.start_is,
        "floor": way.floor,
        "floor_is_proven": way.proven,
        "least_error": least,
        "seconds_of_a_run": raced.limit,
        "runs": [record_of(attempt, way, least) for attempt in raced.attempts],
    }
    return Findings(points, notes=notes_on(raced, points, way, least, refused), numbers=numbers)


def _limit(request: Request, seconds: float, count: int) -> float:
    """Seconds on the wall of one run; where certain times are asked for, what leads beyond these."""
    share = max(seconds / (LEAST_SEEDS * max(count, 1)), SHORTEST)
    asked = [seconds_of(name) for _, name in request.only]
    return 2 * max(asked) if asked else share


def _points(
    scene: Scene, entrant: Entrant, attempts: Sequence[Attempt], way: Way, least: float, request: Request
) -> list[Point]:
    if request.only:
        places = sorted(seconds_of(name) for series, name in request.only if series == entrant.name)
    else:
        everywhere = places_of(attempts)
        medians = [float(np.median(_errors(attempts, place, way, least))) for place in everywhere]
        places = without_repeats(everywhere, medians, change=WORTH)
    if attempts and not places:
        places = [max(attempt.processor for attempt in attempts)]  # all of them failed
    last = places[-1] if places else None
    return [_point(scene, entrant, attempts, place, way, least, place == last) for place in places if attempts]


def _point(
    scene: Scene, entrant: Entrant, attempts: Sequence[Attempt], place: float, way: Way, least: float, is_last: bool
) -> Point:
    errors = _errors(attempts, place, way, least)
    bests = [best for attempt in attempts if (best := attempt.best_at(place)) is not None]
    runs = [attempt.run for attempt in attempts if attempt.run is not None]
    numbers: dict[str, float] = {"runs": len(attempts)}
    if bests:  # what had been spent when the value came
        numbers |= {"evaluations": _median(best.evaluations for best in bests)}
        numbers |= {"solves": _median(best.solves for best in bests)}
    if runs:  # of whole runs
        numbers |= {"overhead_share": _median(overhead_of(run) / max(run.processor_seconds, 1e-9) for run in runs)}
        numbers |= {"overhead_seconds": _median(overhead_of(run) for run in runs)}
    whys = [attempt.why for attempt in attempts if attempt.why]
    return Point(
        series=entrant.name,
        name=name_of(place),
        errors=errors,
        processor=np.array([min(place, attempt.processor) for attempt in attempts]),
        # The share of the processor that a run had was the same throughout, as far as is known.
        wall=np.array([attempt.wall * min(place / max(attempt.processor, 1e-9), 1.0) for attempt in attempts]),
        warm_up=entrant.warm_up,
        # A scene that sets options of an optimizer, and a budget, states a run of it.
        is_stated=is_last and entrant.name in scene.optimizers and not any(attempt.is_cut for attempt in attempts),
        numbers=numbers,
        why=whys[0] if whys else "" if np.isfinite(errors).all() else "no answer yet",
    )


def _errors(attempts: Sequence[Attempt], place: float, way: Way, least: float) -> Floats:
    """What is left of the way at a time, shape (attempts,); inf before the first answer, and where a run failed."""
    bests = [attempt.best_at(place) for attempt in attempts]
    return np.array([np.inf if best is None else max(way.gap(best.value), least) for best in bests])


def _median(numbers: Iterable[float]) -> float:
    return float(np.median(list(numbers)))
