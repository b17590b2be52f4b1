"""Runs that failed: unsuccessful ones, of which nothing else is known."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from springopt.comparison.record import Record
from springopt.comparison.result_files import ResultFile

FAILED = "failed"  # the word where all runs of a method on a scene did


@dataclass(frozen=True)
class Failure:
    """A run that failed."""

    scene: str
    method: str
    sentence: str  #: how


def failures_of(files: Sequence[ResultFile], records: Sequence[Record]) -> list[Failure]:
    """The runs that failed, unless they were made after all.

    Where settings are kept apart under one label, a file of a failure does not say which it was with: it counts
    against each, so that none looks better than it is.
    """
    made = {record.path.resolve() for record in records}
    failures = []
    for file in files:
        run = file.path.with_name(file.path.name.replace(".failed.json", ".h5"))
        if file.scene is None or file.label is None or run.resolve() in made:
            continue
        its = {(record.scene, record.method) for record in records if record.label == file.label}
        here = {method for scene, method in its if scene == file.scene} or {method for _, method in its}
        sentence = file.says("sentence")["sentence"]
        failures += [Failure(file.scene, method, sentence) for method in sorted(here or {file.label})]
    return failures


def without_run(failures: Sequence[Failure], records: Sequence[Record]) -> list[Failure]:
    """One for each method on each scene where no run is left."""
    there = {(record.scene, record.method) for record in records}
    lost = {(each.scene, each.method): each for each in failures}
    return [each for pair, each in lost.items() if pair not in there]


def failures_told(failures: Sequence[Failure]) -> list[str]:
    """A sentence if runs failed."""
    if not failures:
        return []
    counts = Counter((each.method, each.scene) for each in failures)
    runs = ", ".join(f"{count} of {method} on {scene}" for (method, scene), count in sorted(counts.items()))
    return [
        f"runs failed ({runs}): they are unsuccessful in success rates and curves; what they reached and spent is not "
        "known, so that gaps, tests and running times are of the other runs alone."
    ]
