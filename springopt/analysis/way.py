"""The scale of a scene's values: from a start that needs no search to the lowest value known."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Way:
    """From a scene's start, which needs no search, to the lowest value known of it."""

    start: float
    start_is: str  #: what the start's value is of
    floor: float
    proven: bool  #: whether no value can be lower
    notes: tuple[str, ...] = ()  #: sentences, where start or floor are not the stored ones

    def gap(self, value: float) -> float:
        """The share of the way that is left: 0 at the floor, 1 at the start, more above it."""
        return (value - self.floor) / self.length

    def target(self, exponent: int) -> float:
        """The value of a target; one that is not above it has solved it."""
        return self.floor + 10.0**-exponent * self.length

    @property
    def length(self) -> float:
        return self.start - self.floor if self.start > self.floor else 1.0
