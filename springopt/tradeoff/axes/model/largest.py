"""The largest model that keeps up with a rate: the scene's body on more and more nodes, until they are too many."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from springopt.checks import Integers
from springopt.scene import Scene
from springopt.scene.build import build_model
from springopt.scene.lattice_tables import GridTable
from springopt.scene.load_case_tables import LoadCaseTable
from springopt.scene.reference_tables import SpringTable
from springopt.tradeoff.axes.model.identification import Identified
from springopt.tradeoff.axes.model.real_time import LEAST_STEPS, Clockwork, Step, moving, time_step
from springopt.tradeoff.axes.model.resampling import resampled, stiffness_factor
from springopt.tradeoff.axes.model.variation import with_encoding

RATES = {"1 kHz": 1e-3, "60 Hz": 1 / 60}  # seconds that a step may take
FASTEST_GROWTH = 2.0  # of the cells along an axis, from one measurement to the next
SHRUNK = 0.8  # where the time does not allow so many
CALLS = 5  # of a motion, until its step is known
OF_VERIFYING = 0.2  # of the time, to measure once more what was found


@dataclass(frozen=True)
class Size:
    """A lattice that was timed."""

    cells: tuple[int, ...]
    springs: int
    step: Step

    @property
    def seconds(self) -> float:
        """Of the processor, a step."""
        return self.step.seconds.value

    @property
    def said(self) -> str:
        """As in "13 x 13 nodes (624 springs)"."""
        return f"{' x '.join(str(count + 1) for count in self.cells)} nodes ({self.springs:,} springs)"


@dataclass(frozen=True)
class Kept:
    """How large a model may be for a rate."""

    rate: str
    largest: Size | None  #: that keeps it, measured twice; None where none was found
    is_largest: bool  #: whether the next larger one was measured, and is too slow
    sentence: str

    def numbers(self) -> dict[str, Any]:
        found: dict[str, Any] = {"is_largest": self.is_largest}
        if self.largest is not None:
            nodes = [count + 1 for count in self.largest.cells]
            found |= {"nodes": nodes, "springs": self.largest.springs, "step_seconds": self.largest.seconds}
            found |= {"step_wall_seconds": self.largest.step.wall.value}
        return found


@dataclass(eq=False)
class Sizes:
    """The lattices of a body by their cells along the longest axis; it changes itself, to time each one once."""

    scene: Scene
    homogeneous: Identified  #: whose stiffness they have, as far as the spacing asks; a time hardly depends on it
    clock: Clockwork
    timed: dict[int, Size] = field(default_factory=dict)

    def measure(self, count: int, seconds: float) -> Size | None:
        """None where the motion breaks off."""
        cells = self.cells(count)
        finer = resampled(self.scene, cells.tolist())
        lattice = finer.lattice.build()
        model = build_model(finer, lattice)
        encoding = finer.encoding.build_for(model)
        point = self.homogeneous.point.copy()
        point[0] *= stiffness_factor(self.homogeneous.setup.scene, cells.tolist())
        case = finer.load_cases.build(lattice)[0]
        body = moving(self.clock, model, encoding.decode(point), case, finer.objective.tolerance)
        step = time_step(body, seconds)
        return None if step is None else Size(tuple(cells.tolist()), lattice.spring_count, step)

    def cells(self, count: int) -> Integers:
        """Along each axis, where the longest has so many."""
        assert isinstance(self.scene.lattice, GridTable)
        own = np.array(self.scene.lattice.grid) - 1
        return np.maximum(1, np.round(count * own / own.max())).astype(int)

    @property
    def own(self) -> int:
        assert isinstance(self.scene.lattice, GridTable)
        return max(self.scene.lattice.grid) - 1

    @property
    def power(self) -> int:
        """Of the cells along an axis with which the work of a band's factor grows: n nodes times width squared."""
        assert isinstance(self.scene.lattice, GridTable)
        return 3 * len(self.scene.lattice.grid) - 2


def stage(scene: Scene) -> Scene | None:
    """The scene with one load case, homogeneous springs, and a reference that nobody asks for.

    None where no load case is held by sides alone, as it would have to be on any number of nodes.
    """
    for case in [*scene.load_cases.train, *scene.load_cases.test]:
        if all(isinstance(name, str) for name in _held(case)):
            cases = scene.load_cases.model_copy(update={"train": [case], "test": []})
            springs = SpringTable.model_validate({"kind": "spring", "stiffness": 1.0})
            tables = {"load_cases": cases, "reference": springs}
            return with_encoding(scene, "homogeneous").model_copy(update=tables)
    return None


def _held(case: LoadCaseTable) -> list[str | int]:
    """The sides and nodes that are held or moved."""
    return [name for hold in case.hold for name in hold.on] + [name for move in case.move for name in move.on]


def largest_that_keeps(rate: str, sizes: Sizes, seconds: float) -> Kept:
    """By measuring sizes between one that keeps the rate and one that does not, until they are neighbours."""
    limit, until = RATES[rate], time.perf_counter() + seconds * (1 - OF_VERIFYING)
    while True:
        kept = [count for count, size in sizes.timed.items() if size.seconds <= limit]
        slow = [count for count, size in sizes.timed.items() if size.seconds > limit]
        low, high = max(kept, default=0), min(slow, default=None)
        low = low if high is None or low < high else max((count for count in kept if count < high), default=0)
        if high is not None and high - low <= 1:
            break
        count, left = _next(sizes, limit, low, high), until - time.perf_counter()
        while not _fits(sizes, count, left) and count > low + 1:
            count = max(low + 1, int(SHRUNK * count))  # less than might be had is more than nothing
        if not _fits(sizes, count, left):
            break
        size = sizes.measure(count, 0.0)
        if size is None:
            break
        sizes.timed[count] = size
    return _verified(rate, sizes, low, high, seconds * OF_VERIFYING)


def _next(sizes: Sizes, limit: float, low: int, high: int | None) -> int:
    """The size that should take just as long as it may, by how times grow, between what was measured."""
    if not sizes.timed:
        return sizes.own
    known = low or high
    assert known is not None
    guess = known * (limit / sizes.timed[known].seconds) ** (1 / sizes.power)
    if low and high is not None:
        fast, slow = sizes.timed[low].seconds, sizes.timed[high].seconds
        share = np.log(limit / fast) / max(np.log(slow / fast), 1e-9)
        guess = low * (high / low) ** share
    top = int(FASTEST_GROWTH * low) if high is None else high - 1
    return int(np.clip(round(guess), low + 1, max(top, low + 1)))


def _fits(sizes: Sizes, count: int, left: float) -> bool:
    """Whether a size can be measured in the seconds that are left, by what the nearest one took."""
    if not sizes.timed:
        return True
    nearest = min(sizes.timed, key=lambda other: abs(other - count))
    expected = sizes.timed[nearest].seconds * (count / nearest) ** sizes.power
    return CALLS * LEAST_STEPS * expected <= left


def _verified(rate: str, sizes: Sizes, low: int, high: int | None, seconds: float) -> Kept:
    """What was found, measured once more; the next smaller one where it was found by luck."""
    is_next = high is not None and high - low <= 1
    while low:
        again = _again(sizes, low, RATES[rate], seconds)
        if again is not None:
            bound = "at most" if is_next else "at least"
            return Kept(rate, again, is_next, f"{rate} is kept by {bound} {again.said}, {_ms(again.seconds)} a step.")
        low, seconds = low - 1, seconds / 2
    tried = min(sizes.timed.values(), key=lambda size: size.springs, default=None)
    said = "" if tried is None else f": {tried.said} take {_ms(tried.seconds)} a step"
    return Kept(rate, None, False, f"{rate} is kept by no lattice of this body that was measured{said}.")


def _again(sizes: Sizes, count: int, limit: float, seconds: float) -> Size | None:
    """A size by a new measurement that keeps the limit, or by a third one where two differ; None where it does not."""
    for _ in range(2 if count in sizes.timed else 1):
        size = sizes.measure(count, seconds)
        if size is not None and size.seconds <= limit:
            return size
    return None


def _ms(seconds: float) -> str:
    return f"{1e3 * seconds:.3g} ms"
