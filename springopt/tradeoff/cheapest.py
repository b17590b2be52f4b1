"""The reverse question: the cheapest setting that is accurate enough, or the most accurate that is fast enough.

What was measured proposes a setting, and a run of its own, with another seed, has to confirm it; where it does not, the
next one is tried.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from springopt.scene import Setup
from springopt.tradeoff.measure import Measured
from springopt.tradeoff.point import Point, Request

MOST_TRIED = 5
VERIFYING_SEED = 1


@dataclass(frozen=True, eq=False)
class Answer:
    """What an axis has to offer."""

    measured: Measured
    target_error: float | None
    time: float | None  #: processor seconds
    #: The setting as it was confirmed; None where no setting meets what was asked.
    verified: Point | None
    refuted: Sequence[Point]  #: those that a run of their own did not confirm
    closest: Point | None  #: where none meets it, the one that comes closest, as it was measured

    @property
    def said(self) -> str:
        """One sentence, or two."""
        wanted = f"an error of {self.target_error:.3g}" if self.target_error is not None else f"{self.time:.3g} s"
        axis, call = self.measured.axis, self.measured.call
        what, better = ("cheapest", "cheaper") if self.target_error is not None else ("most accurate", "more accurate")
        count = len(self.refuted)
        if self.verified is not None:
            refuted = f" {count} {better} did not hold when run again." if count else ""
            return (
                f"{axis.name}: the {what} setting that keeps {wanted} is {call(self.verified)}; run again, its error "
                f"is {_said(self.verified)}.{refuted}"
            )
        if self.closest is None:
            return f"{axis.name}: no setting has an answer in every case."
        if count:
            return (
                f"{axis.name}: no setting is sure to keep {wanted}; {count} that did ({call(self.refuted[0])}"
                f"{' and others' if count > 1 else ''}) did not hold when run again."
            )
        return f"{axis.name}: no setting keeps {wanted}; closest is {call(self.closest)}, {_said(self.closest)}."


def find_cheapest(
    setup: Setup, measured: Measured, *, target_error: float | None = None, time: float | None = None, seconds: float
) -> Answer:
    """The setting of one axis that meets a target, verified by runs that take about so many seconds together.

    Args:
        target_error: the cheapest one whose error is at most this, to the upper end of its interval.
        time: the most accurate one that takes at most so many processor seconds, to the upper end.
    """
    assert (target_error is None) != (time is None), "one question at a time"
    cost: Callable[[Point], float]
    if target_error is not None:
        limit, meets, cost = target_error, _upper_error, lambda point: point.processor_seconds.value
    else:
        assert time is not None
        limit, meets, cost = time, _upper_time, _middle_error
    good = [point for point in measured.points if not point.is_apart and point.is_good and point.error is not None]
    proposed = sorted((point for point in good if meets(point) <= limit), key=cost)[:MOST_TRIED]
    refuted: list[Point] = []
    for point in proposed:
        again = _run_again(setup, measured, point, seconds / len(proposed))
        if again is not None and again.is_good and meets(again) <= limit:
            return Answer(measured, target_error, time, again, refuted, None)
        refuted.append(point)
    return Answer(measured, target_error, time, None, refuted, min(good, key=meets, default=None))


def _run_again(setup: Setup, measured: Measured, point: Point, seconds: float) -> Point | None:
    wanted = (point.series, point.name)
    before = measured.findings.numbers
    request = Request(seconds, seed=VERIFYING_SEED, only=frozenset([wanted]), before=before)
    found = measured.axis.measure(setup, request).points
    return next((again for again in found if (again.series, again.name) == wanted and again.error is not None), None)


def _upper_error(point: Point) -> float:
    assert point.error is not None
    return point.error.high


def _middle_error(point: Point) -> float:
    assert point.error is not None
    return point.error.value


def _upper_time(point: Point) -> float:
    return point.processor_seconds.high


def _said(point: Point) -> str:
    error, seconds = point.error, point.processor_seconds
    assert error is not None
    return (
        f"{error.value:.3g} ({error.low:.3g} to {error.high:.3g}) in {seconds.value:.3g} s "
        f"({seconds.low:.3g} to {seconds.high:.3g})"
    )
