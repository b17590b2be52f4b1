"""Whether a number of the paper lies within what the seeds give here, in a sentence."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from springopt.reproduction.paper import Published
from springopt.reproduction.spread import Spread


@dataclass(frozen=True)
class Comparison:
    """A number of the paper beside ours, and beside what other readings of the paper give."""

    what: str
    paper: Published
    ours: Sequence[float]  #: one a seed
    form: str  #: how the number is written
    readings: Mapping[str, Sequence[float]] = field(default_factory=dict)

    @property
    def agrees(self) -> bool:
        return _agrees(self.paper, self.ours)

    def said(self) -> str:
        """The verdict, as Markdown."""
        spread = Spread.of(self.ours)
        both = f"{self.what}: {self.paper.printed} in the paper ({self.paper.where}), {spread.said(self.form)} here"
        if self.agrees:
            return f"{both}: **within the seeds' spread**."
        gap = abs(spread.gap(self.paper.value))
        share = f" ({gap / abs(self.paper.value):.1%})" if self.paper.value else ""
        return f"{both}: **differs by {gap:{self.form}}{share}, more than the seeds' spread**{self._tried()}."

    def _tried(self) -> str:
        if not self.readings:
            return ""
        tried = (
            f"{name}, {Spread.of(numbers).said(self.form)} ({'within' if _agrees(self.paper, numbers) else 'differs'})"
            for name, numbers in self.readings.items()
        )
        return f"; readings tried: {'; '.join(tried)}"


def _agrees(paper: Published, numbers: Sequence[float]) -> bool:
    return Spread.of(numbers).holds(paper.value, paper.rounding)
