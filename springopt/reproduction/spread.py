"""What several seeds make of one number."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from statistics import median


@dataclass(frozen=True)
class Spread:
    """The numbers of several seeds: the middle one, the least and the greatest."""

    middle: float
    least: float
    greatest: float

    @classmethod
    def of(cls, numbers: Iterable[float]) -> Spread:
        found = sorted(map(float, numbers))
        return cls(median(found), found[0], found[-1])

    def said(self, form: str) -> str:
        """As in "5.03 (5.01 to 5.04)"; one number where the seeds agree as far as it is shown."""
        middle, least, greatest = (format(number, form) for number in (self.middle, self.least, self.greatest))
        return middle if least == greatest else f"{middle} ({least} to {greatest})"

    def holds(self, value: float, rounding: float = 0.0) -> bool:
        """Whether a number that is rounded by so much lies within."""
        return self.least - rounding <= value <= self.greatest + rounding

    def gap(self, value: float) -> float:
        """How far a number is from the nearest of the seeds; negative where it lies below all of them."""
        return min(value - self.least, 0.0) + max(value - self.greatest, 0.0)
