"""From the runs of all optimizers to points of what is left over what was spent."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from springopt.analysis.way import Way
from springopt.checks import Floats
from springopt.run import Run
from springopt.scene import Scene, Setup
from springopt.tradeoff.axes.optimizer.entrants import Entrant, entrants_of, say_refused
from springopt.tradeoff.axes.optimizer.places import name_of, places_of, seconds_of, without_repeats
from springopt.tradeoff.axes.optimizer.runs import LEAST_SEEDS, Attempt, race
from springopt.tradeoff.axes.optimizer.scale import resolution, way_of
from springopt.tradeoff.point import Findings, Point, Request

WORTH = 0.05  # a gain of the median error that is worth a point
LEAST_SHARE = 0.25  # of the seconds: what warm-ups leave at least for runs
SHORTEST = 0.05  # seconds of a run
EXPONENTS = (1, 2, 3, 4, 5, 6)  # of targets, as negative powers of ten
MOST_IMPROVEMENTS = 50  # of a run, in the numbers


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
    way = way_of(setup, raced.attempts)
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
        "runs": [_numbers(attempt, way, least) for attempt in raced.attempts],
    }
    return Findings(points, notes=_notes(raced.attempts, way, least, refused), numbers=numbers)


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
        numbers |= {"overhead_share": _median(_overhead(run) / max(run.processor_seconds, 1e-9) for run in runs)}
        numbers |= {"overhead_seconds": _median(_overhead(run) for run in runs)}
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


def _notes(attempts: Sequence[Attempt], way: Way, least: float, refused: Mapping[str, str]) -> list[str]:
    return [
        f"1 is the objective of {way.start_is}, {way.start:.4g}; 0 is the floor, {way.floor:.6g}"
        f"{' (proven)' if way.proven else ''}.",
        *way.notes,
        *([_first_below(attempts, way)] if any(attempt.run for attempt in attempts) else []),
        *_at_the_floor(attempts, way, least),
        *say_refused(refused),
    ]


def _first_below(attempts: Sequence[Attempt], way: Way) -> str:
    """Who is there first, by the median of its runs, those that never come counted as such."""
    firsts: dict[str, list[str]] = {}
    for exponent in EXPONENTS:
        times = {name: _median(_arrivals(attempts, name, way, exponent)) for name in _names(attempts)}
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


def _at_the_floor(attempts: Sequence[Attempt], way: Way, least: float) -> list[str]:
    if any(attempt.run is not None and way.gap(attempt.run.objective) <= least for attempt in attempts):
        return [f"Errors are not below {least:.1g}: the tolerance of the forward solve can't tell less from zero."]
    return []


def _numbers(attempt: Attempt, way: Way, least: float) -> dict[str, Any]:
    """A run for machines: what it cost, solves and overhead apart, and its improvements."""
    head = {"optimizer": attempt.optimizer, "seed": attempt.seed, "why": attempt.why}
    times = {"processor_seconds": attempt.processor, "seconds": attempt.wall}
    run = attempt.run
    if run is None:
        return head | times
    return {
        **head,
        **times,
        "solving_seconds": run.solving_seconds,
        "overhead_seconds": _overhead(run),
        "evaluations": run.evaluations,
        "solves": run.solves,
        "objective": run.objective,
        "error": max(way.gap(run.objective), least),
        "why_stopped": run.why_stopped,
        "improvements": [
            each._asdict() | {"error": max(way.gap(each.value), least)} for each in _thinned(run, way, least)
        ],
    }


def _thinned(run: Run, way: Way, least: float) -> list[Any]:
    """So many improvements at most, the first and the last, and evenly over the decades of the gap between them."""
    gaps = np.log10([max(way.gap(each.value), least) for each in run.history])
    steps = np.linspace(gaps[0], gaps[-1], MOST_IMPROVEMENTS - 1)
    kept = {0, len(gaps) - 1, *np.minimum(np.searchsorted(-gaps, -steps), len(gaps) - 1).tolist()}
    return [run.history[number] for number in sorted(kept)]


def _overhead(run: Run) -> float:
    """Seconds of the processor that are the optimizer's own."""
    return run.processor_seconds - run.solving_seconds


def _names(attempts: Sequence[Attempt]) -> list[str]:
    return list(dict.fromkeys(attempt.optimizer for attempt in attempts))


def _median(numbers: Any) -> float:
    return float(np.median(list(numbers)))
