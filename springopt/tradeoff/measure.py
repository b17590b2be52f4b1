"""The tradeoff of a scene: every axis that it has measured, what one digit more costs, and where to spend."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from springopt.errors import UserError
from springopt.scene import Setup
from springopt.tradeoff.clock import Progress
from springopt.tradeoff.front import Price, pareto_front, price_of_a_digit
from springopt.tradeoff.point import Axis, Findings, Point, Request
from springopt.tradeoff.warm_up import compile_kernels

LEAST_SHARE = 0.25  # of an equal one


@dataclass(frozen=True, eq=False)
class Measured:
    """An axis that was measured."""

    axis: Axis
    findings: Findings
    seconds: float  #: that it took, on the wall

    @property
    def points(self) -> Sequence[Point]:
        return self.findings.points

    @property
    def front(self) -> list[Point]:
        return pareto_front(self._together)

    @property
    def price(self) -> Price | None:
        """Of a digit along the front."""
        return price_of_a_digit(self._together) if self.axis.is_graded else None

    @property
    def prices(self) -> dict[str, Price]:
        """Of a digit along each series that has one."""
        names = dict.fromkeys(point.series for point in self.points if self.axis.is_graded)
        found = {name: price_of_a_digit([p for p in self.points if p.series == name]) for name in names}
        return {name: price for name, price in found.items() if price is not None}

    @property
    def stated(self) -> Point | None:
        """What the scene states, where it has an error."""
        return next((point for point in self._together if point.is_stated and point.error is not None), None)

    def call(self, point: Point) -> str:
        """Its setting in a sentence: as in "exact, lanes, tolerance 1e-4", or "without gravity"."""
        return f"{point.series}{', ' if self.axis.is_graded else ' '}{point.name}"

    @property
    def _together(self) -> list[Point]:
        """Those that one truth judges."""
        return [point for point in self.points if not point.is_apart]


@dataclass(frozen=True, eq=False)
class Tradeoff:
    """All axes of a scene."""

    measured: Sequence[Measured]
    missing: Mapping[str, str]  #: axes that the scene does not have, and why


def measure(setup: Setup, axes: Sequence[Axis], *, seconds: float, progress: Progress | None = None) -> Tradeoff:
    """Measures axes one after the other, for so many seconds together; what one leaves the others share.

    One that others left no time has some even so. What is compiled once on a machine comes before the clock.

    Raises UserError where the scene has none of them.
    """
    missing = {axis.name: why for axis in axes if (why := axis.missing(setup.scene)) is not None}
    present = [axis for axis in axes if axis.name not in missing]
    if not present:
        said = "; ".join(f"{name}: {why}" for name, why in missing.items())
        raise UserError(f"scene {setup.scene.name} has none of these axes ({said}); name another --axis.")
    is_motion = setup.scene.load_cases.times is not None
    compile_kernels(in_motion=is_motion or any(axis.second_time for axis in present))
    measured: list[Measured] = []
    begin = time.perf_counter()
    for number, axis in enumerate(present):
        share = (seconds - (time.perf_counter() - begin)) / (len(present) - number)
        measured.append(_measured(setup, axis, max(share, LEAST_SHARE * seconds / len(present)), progress))
    return Tradeoff(measured, missing)


def _measured(setup: Setup, axis: Axis, seconds: float, progress: Progress | None) -> Measured:
    def show(done: int, total: int | None, words: str) -> None:
        if progress:
            progress(done, total, f"{axis.name}: {words}")

    begin = time.perf_counter()
    findings = axis.measure(setup, Request(seconds, show))
    return Measured(axis, findings, time.perf_counter() - begin)
