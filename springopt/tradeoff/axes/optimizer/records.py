"""A run as plain numbers, for machines: what it cost, solves and overhead apart, and how it went down."""

from __future__ import annotations

from typing import Any

import numpy as np

from springopt.analysis.way import Way
from springopt.run import Improvement, Run
from springopt.tradeoff.axes.optimizer.runs import Attempt

MOST_IMPROVEMENTS = 50  # that are written down of a run


def record_of(attempt: Attempt, way: Way, least: float) -> dict[str, Any]:
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
        "overhead_seconds": overhead_of(run),
        "evaluations": run.evaluations,
        "solves": run.solves,
        "objective": run.objective,
        "error": max(way.gap(run.objective), least),
        "why_stopped": run.why_stopped,
        "improvements": [
            each._asdict() | {"error": max(way.gap(each.value), least)} for each in thinned(run, way, least)
        ],
    }


def thinned(run: Run, way: Way, least: float) -> list[Improvement]:
    """So many improvements at most, the first and the last, and evenly over the decades of the gap between them."""
    gaps = np.log10([max(way.gap(each.value), least) for each in run.history])
    steps = np.linspace(gaps[0], gaps[-1], MOST_IMPROVEMENTS - 1)
    kept = {0, len(gaps) - 1, *np.minimum(np.searchsorted(-gaps, -steps), len(gaps) - 1).tolist()}
    return [run.history[number] for number in sorted(kept)]


def overhead_of(run: Run) -> float:
    """Seconds of the processor that are the optimizer's own."""
    return run.processor_seconds - run.solving_seconds
