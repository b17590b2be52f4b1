"""Simulated annealing of spring constants, after Deussen, Kobbelt and Tücke (1995).

"Using simulated annealing to obtain good nodal approximations of deformable bodies", Computer Animation and Simulation
'95. The acceptance is that of Metropolis et al. (1953); what is chosen here stands in this plugin's README.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from springopt.checks import Floats
from springopt.errors import UserError
from springopt.optimizer import Optimizer
from springopt.problem import Problem

PROPOSALS = 20  # at one temperature
CHANGES = 50  # of the value, whose median is its spread
WISHED_RATE = 0.44  # share of accepted steps; best for one number at a time (Roberts and Rosenthal 2001)
ROUNDING = 1e-12  # of a value, by which none is refused that is accepted in the last bit
GROWTH = 1.1  # of a step that was accepted
CYCLE = 200  # proposals for each number in the first cooling where the budget knows no end


@dataclass(frozen=True)
class Annealing(Optimizer):
    """Simulated annealing: one number moved, or one bit flipped, at a time; uphill as the temperature allows.

    The temperature falls by the same factor in each equal part of the budget. Where that has no end, it falls again
    and again, each time twice as slowly.
    """

    name: ClassVar[str] = "annealing"
    draws: int = 10  #: points drawn at first, the best of which is where the search begins
    first: float = 1.0  #: first temperature, in medians of the change that a first proposal makes to the value
    last: float = 1e-4  #: last temperature, as a share of the first
    step: float = 0.25  #: first deviation of a number's step, as a share of its interval; each adapts itself

    def __post_init__(self) -> None:
        for option, (lowest, highest) in _RANGES.items():
            if not lowest <= getattr(self, option) <= highest:
                raise UserError(
                    f"option {option} of annealing lies in [{lowest:g}, {highest:g}], not at "
                    f"{getattr(self, option):g}; give another value."
                )

    def minimize(self, problem: Problem, rng: np.random.Generator) -> None:
        points = problem.sample(rng, self.draws)
        values = problem.evaluate(points)
        walk = Walk(points[values.argmin()], float(values.min()), np.full(problem.size, self.step))
        while left := problem.budget_left:
            temperature = self.first * walk.spread * self.last ** cooled(walk.asked + self.draws, left, problem.size)
            accepted = sum(walk.propose(problem, temperature, rng) for _ in range(PROPOSALS))
            problem.note(temperature=temperature, acceptance_rate=accepted / PROPOSALS)


_RANGES = {"draws": (1, math.inf), "first": (0, math.inf), "last": (1e-300, 1), "step": (1e-9, 1)}


def cooled(asked: int, left: float, size: int) -> float:
    """How far the cooling has come, from 0 to 1; where the budget has no end, in cycles, each twice as long."""
    if math.isfinite(left):
        return asked / (asked + left)
    turns = 1.0 + asked / (CYCLE * size)
    return turns / 2.0 ** math.floor(math.log2(turns)) - 1.0


@dataclass
class Walk:
    """Where the search is, and what it learned of the way; it changes with every proposal."""

    point: Floats  #: shape (size,)
    value: float
    steps: Floats  #: deviation of each number's step, as a share of its interval, shape (size,)
    changes: list[float] = field(default_factory=list)  #: of the value by the first proposals that made one
    asked: int = 0

    @property
    def spread(self) -> float:
        """The objective's own: the median change of its value."""
        return float(np.median(self.changes)) if self.changes else 0.0

    def propose(self, problem: Problem, temperature: float, rng: np.random.Generator) -> bool:
        """Proposes one point, and goes there if it is no worse, or else as the temperature allows."""
        which = int(rng.integers(problem.size))
        proposed = self.point.copy()
        proposed[which] = self._moved(which, problem, rng)
        drawn = rng.random()
        value = self._value(problem, proposed, temperature, drawn)
        self.asked += 1
        if value != self.value and len(self.changes) < CHANGES:
            self.changes.append(abs(value - self.value))
        accepted = drawn < chance(value - self.value, temperature)
        if accepted:
            self.point, self.value = proposed, value
        self._adapt(which, accepted)
        return accepted

    def _value(self, problem: Problem, proposed: Floats, temperature: float, drawn: float) -> float:
        """The value of a point that may be accepted, or where the changes are asked for; inf where it is refused."""
        if len(self.changes) < CHANGES:
            return float(problem.evaluate(proposed[None])[0])
        best = problem.best_of(proposed[None], 1, rivals=[highest(self.value, temperature, drawn)])
        return float(best.values[0]) if len(best.values) else math.inf

    def _moved(self, which: int, problem: Problem, rng: np.random.Generator) -> float:
        """The bit flipped, or the number a normal step further, turned back at the ends of its interval."""
        if problem.kind == "binary":
            return 1.0 - self.point[which]
        lower, upper = problem.lower[which], problem.upper[which]
        step = self.steps[which] * (upper - lower) * rng.standard_normal()
        beyond = (self.point[which] + step - lower) % (2.0 * (upper - lower))
        return min(max(lower + min(beyond, 2.0 * (upper - lower) - beyond), lower), upper)  # rounding may leave it

    def _adapt(self, which: int, accepted: bool) -> None:
        """Longer steps where they are accepted too often; in balance at the wished rate."""
        factor = GROWTH if accepted else GROWTH ** (-WISHED_RATE / (1.0 - WISHED_RATE))
        self.steps[which] = min(max(self.steps[which] * factor, 1e-9), 1.0)


def chance(change: float, temperature: float) -> float:
    """The probability to accept a change of the value (Metropolis et al. 1953)."""
    if change <= 0:
        return 1.0
    return math.exp(-change / temperature) if temperature > 0 else 0.0


def highest(value: float, temperature: float, drawn: float) -> float:
    """At least the highest value that is accepted from this one, by a number drawn from [0, 1)."""
    if not drawn:
        return math.inf
    allowed = -temperature * math.log(drawn)
    return value + allowed + ROUNDING * (abs(value) + allowed)
