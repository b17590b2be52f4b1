"""An experiment of the paper: the runs it needs, and what they say."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from springopt.benchmark import Job
from springopt.reproduction.extent import Extent
from springopt.reproduction.runs import Runs


@dataclass(frozen=True)
class Picture:
    """A figure, the name of its file without ending, and what one sees."""

    name: str
    figure: Any  #: of `springopt.report`
    shows: str


@dataclass(frozen=True)
class Table:
    """Cells of Markdown under their heads."""

    heads: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]
    note: str = ""  #: what stands above it


@dataclass(frozen=True)
class Section:
    """What the page says of an experiment, in the order in which it is read."""

    paper: str  #: what the paper says
    tables: list[Table]
    pictures: list[Picture]
    verdicts: list[str]  #: computed from the runs
    explained: str  #: where the difference comes from
    setting: str = ""  #: what is ours: scene, seeds, budget


@dataclass(frozen=True)
class Experiment:
    """One small thing that can be repeated alone."""

    name: str  #: for `--only`
    title: str
    jobs: Callable[[Extent], list[Job]]
    section: Callable[[Runs, Extent], Section]
