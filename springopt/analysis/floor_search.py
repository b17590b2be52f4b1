"""The lowest value of a scene's own misfit that is found from many starts, and how many of them agree on it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from springopt.analysis.descent import distance_optimum, gradient_optimum, least_squares_optimum
from springopt.budget import Budget
from springopt.checks import Floats, Integers
from springopt.encoding import Real
from springopt.errors import NoEquilibrium, UserError
from springopt.problem import Problem
from springopt.scene import Setup

SAME = 1e-6  # relative difference of values that counts as the same optimum
TRIES = 100  # samples for one start that has an equilibrium
LARGE = 10_000_000  # numbers in a Jacobian; steps by larger ones take minutes

Progress = Callable[[int, int, float], None]  # descents done, of how many, lowest value

_UNLIMITED = Budget(evaluations=10**12)


@dataclass(frozen=True, eq=False)
class Found:
    """A point, shape (size,), its value and the evidence."""

    point: Floats
    value: float
    evidence: dict[str, Any]


def search_box(setup: Setup, starts: int, rng: np.random.Generator, first: Floats | None, progress: Progress) -> Found:
    """The lowest of a box of real numbers.

    Many starts, the first one given, are each followed down on the scene's own misfit at once, and again from its
    least-squares optimum; and the lowest point that any of them came by once more, in case that none ended there. By
    gradients alone where a Jacobian would be too large.
    """
    problem = Problem(setup.objective, setup.encoding, _UNLIMITED)
    given = [] if first is None else [first]
    points = [_start(problem, rng, given) for _ in range(starts)]
    if problem.size * len(problem.residuals(points[0])) > LARGE:
        told = _told(points, progress, problem, 0, starts)
        values = problem.evaluate([gradient_optimum(problem, point) for point in told])
        return _found(problem, values, "descents by the gradient, L-BFGS-B")
    squares_alone = setup.objective.minimize == "least-squares"
    total = starts if squares_alone else 2 * starts + 1
    ends = [least_squares_optimum(problem, point) for point in _told(points, progress, problem, 0, total)]
    if not squares_alone:
        different, which = _different(problem, ends)
        total, dimension = 2 * starts + len(different), setup.lattice.dimension
        again = _told([*points, *different], progress, problem, starts, total)
        ends = [distance_optimum(problem, point, dimension) for point in again]
    values = problem.evaluate(ends)
    if not squares_alone:  # of each start the lower of its two ends
        values = np.minimum(values[:starts], values[starts:][which])
        assert problem.best_point is not None
        problem.evaluate(distance_optimum(problem, problem.best_point, dimension)[None])
    return _found(problem, values, "descents on least squares and on the misfit itself")


def search_bits(setup: Setup, starts: int, rng: np.random.Generator, first: Floats | None, progress: Progress) -> Found:
    """The lowest of bits.

    The least-squares optima with every stiffness free between absent and present are rounded, and then one spring is
    flipped after the other as long as that is lower.
    """
    present = setup.encoding.decode(setup.encoding.upper)
    relaxed = Problem(setup.objective, Real(setup.lattice, lower=0.0, upper=present), _UNLIMITED)
    total = 2 * starts + 1
    points = [_start(relaxed, rng, []) for _ in range(starts)]
    ends = [least_squares_optimum(relaxed, point) for point in _told(points, progress, relaxed, 0, total)]
    problem = Problem(setup.objective, setup.encoding, _UNLIMITED)
    given = [np.ones(len(present))] if first is None else [first]
    rounded = [*((end > present / 2).astype(float) for end in ends), *given]
    values = [_flip_down(problem, bits) for bits in _told(rounded, progress, problem, starts, total)]
    return _found(problem, np.array(values), "stiffness relaxed, rounded, then single springs flipped", relaxed)


def _found(problem: Problem, values: Floats, method: str, *others: Problem) -> Found:
    """The best of a problem; the evidence is how many of the starts ended there, by their values, shape (starts,)."""
    assert problem.best_point is not None
    evidence = {
        "method": method,
        "starts": len(values),
        "agreed": sum(_same(problem.best_value, value) for value in values.tolist()),
        "spread": float(np.ptp(values)),
        "evaluations": sum(each.meter.evaluations for each in (problem, *others)),
    }
    return Found(problem.best_point, problem.best_value, evidence)


def _told(points: Sequence[Floats], progress: Progress, problem: Problem, done: int, total: int) -> Iterator[Floats]:
    """The points, each of which counts as done when the next one is asked for."""
    for number, point in enumerate(points, start=done + 1):
        yield point
        progress(number, total, problem.best_value)


def _different(problem: Problem, points: list[Floats]) -> tuple[list[Floats], Integers]:
    """One of those points that have the same value, for each value; and for each point which of these it is."""
    values = problem.evaluate(points)
    order = np.argsort(values, kind="stable")
    is_new = [at == 0 or not _same(values[order[at - 1]], values[i]) for at, i in enumerate(order.tolist())]
    which = np.empty(len(points), dtype=np.int64)
    which[order] = np.cumsum(is_new) - 1
    return [points[i] for i in order[is_new].tolist()], which


def _start(problem: Problem, rng: np.random.Generator, given: list[Floats]) -> Floats:
    """The given start, else a sample that has an equilibrium."""
    for _ in range(TRIES):
        point = given.pop() if given else problem.sample(rng, 1)[0]
        try:
            problem.residuals(point)
        except NoEquilibrium:
            continue
        return point
    raise UserError(
        f"{TRIES} candidates in a row have no equilibrium, so that there is nothing to start from; "
        "raise the lower bound of the encoding, or add supports."
    )


def _flip_down(problem: Problem, bits: Floats) -> float:
    """The value where no flip of a single bit is lower."""
    value = float(problem.evaluate(bits[None])[0])
    while True:
        flipped = np.abs(bits - np.eye(problem.size))
        values = problem.evaluate(flipped)
        best = int(values.argmin())
        if not values[best] < value:
            return value
        bits, value = flipped[best], float(values[best])


def _same(one: float, other: float) -> bool:
    return abs(one - other) <= SAME * max(abs(one), abs(other))
