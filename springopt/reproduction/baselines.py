"""Rows of a table for the baselines: what they found in the same numbers, and what everything cost."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from springopt.reproduction.runs import Runs
from springopt.reproduction.spread import Spread
from springopt.run import Run
from springopt.store import RunFile

#: Behind the numbers of every row.
SPENT = ("evaluations", "processor seconds")
Numbers = Callable[[Sequence[RunFile]], tuple[str, ...]]


def spent(runs: Sequence[Run]) -> tuple[str, str]:
    """What the runs of one row cost."""
    evaluations = Spread.of(run.evaluations for run in runs).middle
    seconds = Spread.of(run.processor_seconds for run in runs).middle
    return f"{evaluations:,.0f}", f"{seconds:.2g}" if seconds < 10 else f"{seconds:.0f}"


def rows(runs: Runs, scene: str, labels: Sequence[str], numbers: Numbers) -> list[tuple[str, ...]]:
    """One row a label: its cells of numbers, then what it cost; an optimizer that can't serve the scene says why."""
    return [_row(runs, scene, label, numbers) for label in labels]


def row(name: str, files: Sequence[RunFile], numbers: Numbers) -> tuple[str, ...]:
    """The cells of one row."""
    return (name, *numbers(files), *spent([file.run for file in files]))


def _row(runs: Runs, scene: str, label: str, numbers: Numbers) -> tuple[str, ...]:
    word = runs.word(scene, label)
    if word is not None:
        return (f"`{label}`", f"can't: {word}")
    return row(f"`{label}`", runs.of(scene, label), numbers)
