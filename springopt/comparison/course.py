"""How the gap of a method falls over the evaluations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from springopt.analysis.way import Way
from springopt.checks import Floats
from springopt.comparison.record import Record

PLACES = 60  # evenly over the logarithm of the evaluations


@dataclass(frozen=True)
class Course:
    """Median and quartiles of the gap, from the first evaluations that all runs have a value at to the longest run."""

    evaluations: list[float]
    median: list[float]
    lower_quartile: list[float]
    upper_quartile: list[float]


def course_of(records: Sequence[Record], way: Way) -> Course:
    """Over the runs of a method on a scene; a run that ended earlier stays at its last value."""
    first = max(record.spent["evaluations"][0] for record in records)
    last = max(record.total["evaluations"] for record in records)
    places = np.unique(np.rint(np.geomspace(first, last, PLACES)))
    gaps = np.array([_gaps_at(places, record, way) for record in records])
    median, lower, upper = np.quantile(gaps, [0.5, 0.25, 0.75], axis=0).tolist()
    return Course(places.tolist(), median, lower, upper)


def _gaps_at(places: Floats, record: Record, way: Way) -> Floats:
    """Gap of the best value up to each place."""
    newest = np.searchsorted(record.spent["evaluations"], places, side="right") - 1
    return (record.values[newest] - way.floor) / way.length
