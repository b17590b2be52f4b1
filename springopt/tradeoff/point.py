"""What an axis offers and finds: settings to measure, and points of error over time."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from springopt.checks import Floats
from springopt.scene import Scene, Setup
from springopt.tradeoff.clock import Progress, Timing, time_all
from springopt.tradeoff.interval import Interval


@dataclass(frozen=True, eq=False)
class Setting:
    """One way of doing it, ready to be run: settings of a series differ by how accurate they are meant to be."""

    series: str  #: as in "exact, lanes"
    name: str  #: as in "tolerance 1e-4"; with the series it names the setting
    run: Callable[[], Any]  #: what is timed
    judge: Callable[[Any], Floats]  #: errors of what `run` returns, (k,), inf where there is no answer; not timed
    solves: int = 1  #: that a call makes: times are of one of them
    states: Mapping[str, Any] = field(default_factory=dict)  #: how a scene states it, as {"objective.tolerance": 1e-4}
    is_stated: bool = False  #: whether the scene states it
    is_apart: bool = False  #: whether another truth judges it than most: it compares with its own series alone
    numbers: Mapping[str, float] = field(default_factory=dict)  #: what else is known of it, as its springs
    second_time: Interval | None = None  #: seconds of what `Axis.second_time` says, where that is known
    #: What else is read off what `run` returns, as its iterations, beside the numbers; and why some are no answers.
    count: Callable[[Any], Mapping[str, float]] = lambda answer: {}
    why: Callable[[Any], str] = lambda answer: ""


@dataclass(frozen=True, eq=False)
class Point:
    """A setting that was measured: errors and times of one solve, in whatever unit the axis has."""

    series: str
    name: str
    errors: Floats  #: of every answer, inf where there was none, shape (k,)
    processor: Floats  #: seconds, a number a repeat, shape (r,)
    wall: Floats  #: seconds, shape (r,)
    warm_up: float = 0.0  #: seconds on the wall
    states: Mapping[str, Any] = field(default_factory=dict)
    is_stated: bool = False
    is_apart: bool = False  #: see `Setting`
    numbers: Mapping[str, Any] = field(default_factory=dict)
    second_time: Interval | None = None  #: see `Setting`
    why: str = ""  #: it failed, where it did

    @property
    def failures(self) -> int:
        """Answers that are none."""
        return int(np.count_nonzero(~np.isfinite(self.errors)))

    @property
    def error(self) -> Interval | None:
        """Of those that are there; None where there is none."""
        found = self.errors[np.isfinite(self.errors)]
        return Interval.of(found) if len(found) else None

    @property
    def processor_seconds(self) -> Interval:
        return Interval.of(self.processor)

    @property
    def wall_seconds(self) -> Interval:
        return Interval.of(self.wall)

    @property
    def is_good(self) -> bool:
        """Whether every answer is one: a setting that fails now and then meets no target."""
        return self.failures == 0


@dataclass(frozen=True)
class Request:
    """How much is measured."""

    seconds: float  #: on the wall, for the whole axis
    progress: Progress | None = None
    #: Of whatever is drawn. A setting is verified with another one than it was chosen by.
    seed: int = 0
    only: frozenset[tuple[str, str]] = frozenset()  #: series and name of settings; all of them if there are none
    #: Numbers of the findings that `only` was chosen from: no less may judge what was chosen.
    before: Mapping[str, Any] = field(default_factory=dict)

    def wants(self, series: str, name: str) -> bool:
        return not self.only or (series, name) in self.only


@dataclass(frozen=True, eq=False)
class Findings:
    """What an axis found."""

    points: Sequence[Point]
    marks: Mapping[str, float] = field(default_factory=dict)  #: times [s] to mark in the figure, by what they are
    notes: Sequence[str] = ()  #: sentences a reader needs
    numbers: Mapping[str, Any] = field(default_factory=dict)  #: what else was found, for machines


@dataclass(frozen=True)
class Axis:
    """One thing to spend time on."""

    name: str  #: for `--axis`
    title: str
    error: str  #: what the error is, for a label
    time: str  #: what takes the time, for a label: "one forward solve"
    missing: Callable[[Scene], str | None]  #: why a scene does not have it, in words that follow "because"; None if so
    measure: Callable[[Setup, Request], Findings]
    second_time: str = ""  #: what else takes time with these settings, for a diagram of its own, that has the marks
    shown: Sequence[str] = ()  #: which of the points' numbers the table shows
    is_graded: bool = True  #: whether its settings are more and more accurate, so that a digit has a price
    #: Whether its error, a share of the displacements as in `errors`, is a part of the whole that no other axis has.
    is_part: bool = True


def measure_settings(settings: Sequence[Setting], request: Request) -> list[Point]:
    """Runs settings for the seconds that are asked for, and judges what they answer."""
    wanted = [setting for setting in settings if request.wants(setting.series, setting.name)]
    tasks = [(f"{setting.series}, {setting.name}", setting.run) for setting in wanted]
    timings = time_all(tasks, request.seconds, request.progress)
    return [_point(setting, timing, setting.run()) for setting, timing in zip(wanted, timings, strict=True)]


def _point(setting: Setting, timing: Timing, answer: Any) -> Point:
    errors = setting.judge(answer)
    return Point(
        series=setting.series,
        name=setting.name,
        errors=errors,
        processor=timing.processor / setting.solves,
        wall=timing.wall / setting.solves,
        warm_up=timing.warm_up,
        states=setting.states,
        is_stated=setting.is_stated,
        is_apart=setting.is_apart,
        second_time=setting.second_time,
        numbers={**setting.numbers, **setting.count(answer)},
        why="" if np.isfinite(errors).all() else setting.why(answer),
    )
