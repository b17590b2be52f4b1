"""The genetic algorithms of Bianchi, Solenthaler, Székely and Harders (2004), binary and real-valued.

"Simultaneous Topology and Stiffness Identification for Mass-Spring Models Based on FEM Reference Deformations",
MICCAI 2004, sections 3.1 and 4.1. The constants that the paper states are the defaults; what it leaves open is an
option whose choices are the readings of it, compared in this plugin's README.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import count
from typing import ClassVar, Literal, NamedTuple

import numpy as np

from springopt.checks import Booleans, Floats, Integers
from springopt.errors import UserError
from springopt.optimizer import Optimizer
from springopt.problem import Problem

Selection = Literal["tournament", "rank", "roulette"]
Crossover = Literal["uniform", "one-point", "two-point"]
Mutation = Literal["every-gene", "gene", "individual"]
Survival = Literal["generational", "compete"]
Limit = Literal["clip", "reflect", "redraw"]
Shape = tuple[int, ...]
Random = np.random.Generator


class Constants(NamedTuple):
    """What the paper has differently for binary and for real encodings."""

    population: int
    a: float
    b: float
    mutation: Mutation


PAPER = {
    "binary": Constants(population=5, a=0.2, b=0.001, mutation="gene"),  # section 3.1
    "real": Constants(population=10, a=5.0, b=0.0, mutation="every-gene"),  # sections 4.2 and 4.3
}

REDRAWS = 100


@dataclass(frozen=True)
class PaperGA(Optimizer):
    """The paper's genetic algorithm: it flips bits where the scene's encoding is binary, and else moves numbers.

    Raises UserError for numbers out of range, and for a mutation that does not fit the encoding.
    """

    name: ClassVar[str] = "paper-ga"
    population: int | None = None  #: individuals; none: as the paper, 5 for a binary encoding, 10 for a real one
    a: float | None = None  #: pmut(g) = a/g + b; none: as the paper, 0.2 for a binary encoding, 5 for a real one
    b: float | None = None  #: pmut(g) = a/g + b; none: as the paper, 0.001 for a binary encoding, 0 for a real one
    pcross: float = 0.8  #: probability that a child has two parents and not one
    selection: Selection = "tournament"  #: how parents are selected
    tournament: int = 2  #: individuals in a tournament, the best of which is selected; 1 gives all the same chance
    crossover: Crossover = "uniform"  #: which genes are the second parent's
    mutation: Mutation | None = None  #: what pmut decides on; none: "gene" for bits, "every-gene" for numbers
    limit_pmut: bool = True  #: pmut above 1 counts as 1, so that the deviation is at most the interval's size
    limit: Limit = "clip"  #: a number that leaves the interval stops at its end, is reflected, or draws its step anew
    survival: Survival = "generational"  #: children replace their parents, or the best of both live on
    elite: int = 1  #: best parents that live on in place of the worst children, where these replace them

    def __post_init__(self) -> None:
        for option, (lowest, highest) in _RANGES.items():
            number = getattr(self, option)
            if number is not None and not lowest <= number <= highest:
                raise UserError(
                    f"option {option} of paper-ga lies in [{lowest}, {highest}], not at {number}; give another value."
                )

    def minimize(self, problem: Problem, rng: Random) -> None:
        population, a, b, mutation = self.constants(problem.kind)
        parents = _sorted(_evaluated(problem, problem.sample(rng, population)))
        for g in count(1):
            pmut = min(a / g + b, 1.0) if self.limit_pmut else a / g + b
            children = self.mutate(self.cross(parents, rng), pmut, mutation, problem, rng)
            parents = SURVIVALS[self.survival](parents, self._best(problem, children, parents.values), self.elite)

    def _best(self, problem: Problem, children: Floats, parents: Floats) -> Population:
        """The children that may survive beside parents with these values, shape (m,); the others need no value."""
        if self.survival == "compete":
            best = problem.best_of(children, len(parents), rivals=parents)
        else:
            best = problem.best_of(children, len(parents) - self.elite)
        return Population(children[best.places], best.values)

    def constants(self, kind: Literal["binary", "real"]) -> Constants:
        """The paper's for this kind of encoding, except those that are given."""
        options = {name: getattr(self, name) for name in Constants._fields}
        constants = PAPER[kind]._replace(**{name: value for name, value in options.items() if value is not None})
        if kind == "binary" and constants.mutation == "every-gene":
            raise UserError("mutation = 'every-gene' of paper-ga would flip every bit; choose 'gene' or 'individual'.")
        if self.survival == "generational" and self.elite >= constants.population:
            raise UserError(
                f"option elite of paper-ga is {self.elite}, and no child could live among {constants.population} "
                "individuals; lower it or raise the population."
            )
        return constants

    def cross(self, parents: Population, rng: Random) -> Floats:
        """Children, shape (m, size), of two parents each; with probability 1 - pcross of the first one alone."""
        first, second = SELECTIONS[self.selection](parents.values, self.tournament, rng)
        has_two = rng.random((len(first), 1)) < self.pcross
        from_second = has_two & CROSSOVERS[self.crossover](parents.points.shape, rng)
        return np.where(from_second, parents.points[second], parents.points[first])

    def mutate(self, points: Floats, pmut: float, mutation: Mutation, problem: Problem, rng: Random) -> Floats:
        """Bits swapped, or numbers with normal steps added, of deviation pmut * size of interval; shape (m, size)."""
        mutated = MUTATIONS[mutation](pmut, points.shape, rng)
        if problem.kind == "binary":
            problem.note(mutation_probability=pmut)
            return np.where(mutated, 1.0 - points, points)
        sigma = pmut * (problem.upper - problem.lower)
        problem.note(mutation_probability=pmut, mutation_deviation=sigma.max())
        moved = LIMITS[self.limit](points, sigma, problem.lower, problem.upper, rng)
        return np.where(mutated, moved, points)


_RANGES: dict[str, tuple[float, float]] = {
    "population": (1, np.inf),
    "a": (0, np.inf),
    "b": (0, np.inf),
    "pcross": (0, 1),
    "tournament": (1, np.inf),
    "elite": (0, np.inf),
}


class Population(NamedTuple):
    """Individuals and their cost; the parents are kept sorted, the best first."""

    points: Floats  #: shape (m, size)
    values: Floats  #: shape (m,)


def _evaluated(problem: Problem, points: Floats) -> Population:
    return Population(points, problem.evaluate(points))


def _sorted(population: Population, best: int | None = None) -> Population:
    """The best, in order; among equals the first in the population."""
    order = np.argsort(population.values, kind="stable")[:best]
    return Population(population.points[order], population.values[order])


def _joined(first: Population, second: Population) -> Population:
    return Population(np.concatenate([first.points, second.points]), np.concatenate([first.values, second.values]))


# Selection: parents sorted by cost -> numbers of the first and the second parent of each child, shape (2, m).


def _tournament(values: Floats, contestants: int, rng: Random) -> Integers:
    return rng.integers(len(values), size=(contestants, 2, len(values))).min(axis=0)


def _rank(values: Floats, _: int, rng: Random) -> Integers:
    """The best of m is m times as likely as the worst."""
    return _wheel(np.arange(len(values), 0.0, -1.0), rng)


def _roulette(values: Floats, _: int, rng: Random) -> Integers:
    """As likely as the cost is below that of the worst parent."""
    fitness = values[-1] - values
    return _wheel(fitness if fitness.any() else np.ones(len(values)), rng)


def _wheel(shares: Floats, rng: Random) -> Integers:
    ends = np.cumsum(shares)
    return np.searchsorted(ends, ends[-1] * rng.random((2, len(shares))))


# Crossover: which genes are the second parent's, shape (m, size).


def _any_gene(shape: Shape, rng: Random) -> Booleans:
    return rng.random(shape) < 0.5


def _behind_one_point(shape: Shape, rng: Random) -> Booleans:
    m, size = shape
    return np.arange(size) >= rng.integers(1, max(size, 2), size=(m, 1))


def _between_two_points(shape: Shape, rng: Random) -> Booleans:
    m, size = shape
    start, end = np.sort(rng.integers(size + 1, size=(2, m, 1)), axis=0)
    return (np.arange(size) >= start) & (np.arange(size) < end)


# Mutation: which genes it meets, shape (m, size).


def _every_gene(pmut: float, shape: Shape, rng: Random) -> Booleans:
    return np.ones(shape, dtype=bool)


def _each_gene(pmut: float, shape: Shape, rng: Random) -> Booleans:
    return rng.random(shape) < pmut


def _one_gene(pmut: float, shape: Shape, rng: Random) -> Booleans:
    m, size = shape
    genes = rng.integers(size, size=(m, 1))
    return (np.arange(size) == genes) & (rng.random((m, 1)) < pmut)


# Limits: points a normal step further, within the box, shape (m, size).


def _clipped(points: Floats, sigma: Floats, lower: Floats, upper: Floats, rng: Random) -> Floats:
    return np.clip(points + sigma * rng.standard_normal(points.shape), lower, upper)


def _reflected(points: Floats, sigma: Floats, lower: Floats, upper: Floats, rng: Random) -> Floats:
    size = upper - lower
    beyond = (points + sigma * rng.standard_normal(points.shape) - lower) % (2 * size)
    # Rounding may leave the box by a bit.
    return np.clip(lower + np.minimum(beyond, 2 * size - beyond), lower, upper)


def _redrawn(points: Floats, sigma: Floats, lower: Floats, upper: Floats, rng: Random) -> Floats:
    """The few that are outside after many draws, as with a huge deviation, are clipped."""
    moved = points + sigma * rng.standard_normal(points.shape)
    for _ in range(REDRAWS):
        outside = (moved < lower) | (moved > upper)
        if not outside.any():
            return moved
        moved = np.where(outside, points + sigma * rng.standard_normal(points.shape), moved)
    return np.clip(moved, lower, upper)


# Survival: the next parents, as many as before; among equals children come first, so that the search may drift.


def _generational(parents: Population, children: Population, elite: int) -> Population:
    m = len(parents.values)
    kept = Population(parents.points[:elite], parents.values[:elite])
    return _sorted(_joined(_sorted(children, m - elite), kept))


def _compete(parents: Population, children: Population, elite: int) -> Population:
    return _sorted(_joined(children, parents), len(parents.values))


SELECTIONS: dict[Selection, Callable[[Floats, int, Random], Integers]] = {
    "tournament": _tournament,
    "rank": _rank,
    "roulette": _roulette,
}
CROSSOVERS: dict[Crossover, Callable[[Shape, Random], Booleans]] = {
    "uniform": _any_gene,
    "one-point": _behind_one_point,
    "two-point": _between_two_points,
}
MUTATIONS: dict[Mutation, Callable[[float, Shape, Random], Booleans]] = {
    "every-gene": _every_gene,
    "gene": _each_gene,
    "individual": _one_gene,
}
LIMITS: dict[Limit, Callable[[Floats, Floats, Floats, Floats, Random], Floats]] = {
    "clip": _clipped,
    "reflect": _reflected,
    "redraw": _redrawn,
}
SURVIVALS: dict[Survival, Callable[[Population, Population, int], Population]] = {
    "generational": _generational,
    "compete": _compete,
}
