"""The floor of a scene: the lowest value of its own misfit that can be found, with its evidence.

Where a mass-spring reference lies in the encoding's set the floor is zero, and that is proven: a misfit is never
negative. Otherwise it is the best known. Real unknowns: many starts, each followed down on the scene's own misfit at
once, and again from its least-squares optimum. Bits: the least-squares optima with every stiffness free between absent
and present, rounded, and then one spring flipped after the other as long as that is lower.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from springopt.analysis.analytic_start import analytic_start
from springopt.analysis.descent import distance_optimum, least_squares_optimum
from springopt.analysis.known_floor import Floor
from springopt.analysis.point import encode, reference_stiffness
from springopt.budget import Budget
from springopt.checks import Floats, Integers
from springopt.encoding import Real
from springopt.errors import NoEquilibrium, UserError
from springopt.forward.status import has_equilibrium
from springopt.problem import Problem
from springopt.scene import Setup

STARTS = 20
SAME = 1e-6  # relative difference of values that counts as the same optimum
TRIES = 100  # samples for one start that has an equilibrium
SAMPLES = 101  # whose median is the start where there is no formula for one
#: A proven zero is reached to this, in smallest rest lengths: what the tolerances of two forward solves leave.
REACHED = 1e-6

Progress = Callable[[int, int, float], None]  # descents done, of how many, lowest value

_UNLIMITED = Budget(evaluations=10**12)


@dataclass(frozen=True, eq=False)
class _Found:
    point: Floats
    value: float
    evidence: dict[str, Any]


def compute_floor(setup: Setup, *, starts: int = STARTS, seed: int = 0, progress: Progress | None = None) -> Floor:
    """The floor of a scene, not yet stored.

    Args:
        setup: the scene.
        starts: how many, at least 1.
        seed: of the starts' sampling.
        progress: called after each descent.
    """
    if starts < 1:
        raise UserError(f"a floor needs at least 1 start, not {starts}; give another number.")
    start = analytic_start(setup)
    zero = _zero(setup)
    if zero is not None:
        return _floor(setup, zero, start, proof="the reference is in the encoding's set, and no misfit is negative")
    search = _search_bits if setup.encoding.kind == "binary" else _search_box
    with threadpool_limits(1, user_api="blas"):  # more threads round differently
        rng, first = np.random.default_rng(seed), None if start is None else start[0]
        found = search(setup, starts, rng, first, progress or (lambda *_: None))
    return _floor(setup, found, start, evidence={"seed": seed})


def floor_at(setup: Setup, point: Floats, source: str) -> Floor:
    """The floor that a point found by other means makes: a run's, which `source` names."""
    value = float(setup.objective.evaluate(setup.encoding.decode(point)[None]).values[0])
    return _floor(setup, _Found(point, value, {"method": source}), analytic_start(setup))


def _floor(
    setup: Setup,
    found: _Found,
    start: tuple[Floats, float] | None,
    *,
    proof: str | None = None,
    evidence: dict[str, Any] | None = None,
) -> Floor:
    versions = {name: version(name) for name in ("springopt", "numpy", "scipy")}
    return Floor(
        scene=setup.scene.name,
        digest=setup.scene.digest(),
        minimize=setup.objective.minimize,
        value=found.value if proof is None else 0.0,
        proof=proof,
        reached=found.value,
        point=found.point.tolist() if proof is None else None,
        analytic=None if start is None else start[1],
        sampled=_sampled(setup) if start is None else None,
        evidence=found.evidence | (evidence or {}) | versions,
    )


def _sampled(setup: Setup) -> float:
    """The median value of random samples: of those that have an equilibrium, if any has one."""
    points = setup.encoding.sample(np.random.default_rng(0), SAMPLES)
    evaluation = setup.objective.evaluate(setup.encoding.decode(points))
    found = has_equilibrium(evaluation.codes)
    return float(np.median(evaluation.values[found] if found.any() else evaluation.values))


def _zero(setup: Setup) -> _Found | None:
    """The point of a reference without noise, if the encoding has one and the forward solve agrees that it is right."""
    reference = reference_stiffness(setup)
    if reference is None or setup.scene.reference.noise is not None:
        return None
    point, is_exact = encode(setup.encoding, reference)
    objective = setup.objective
    value = float(objective.evaluate(setup.encoding.decode(point)[None]).values[0])
    if not is_exact or value > REACHED * objective.smallest_rest_length * len(objective.cases):
        return None
    return _Found(point, value, {"method": "the reference's stiffness", "evaluations": 1})


def _search_box(
    setup: Setup, starts: int, rng: np.random.Generator, first: Floats | None, progress: Progress
) -> _Found:
    problem = Problem(setup.objective, setup.encoding, _UNLIMITED)
    given = [] if first is None else [first]
    points = [_start(problem, rng, given) for _ in range(starts)]
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
    return _found(problem, values, "descents on least squares and on the misfit itself")


def _search_bits(
    setup: Setup, starts: int, rng: np.random.Generator, first: Floats | None, progress: Progress
) -> _Found:
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


def _found(problem: Problem, values: Floats, method: str, *others: Problem) -> _Found:
    """The best of a problem; the evidence is how many of the starts ended there, by their values, shape (starts,)."""
    assert problem.best_point is not None
    evidence = {
        "method": method,
        "starts": len(values),
        "agreed": sum(_same(problem.best_value, value) for value in values.tolist()),
        "spread": float(np.ptp(values)),
        "evaluations": sum(each.meter.evaluations for each in (problem, *others)),
    }
    return _Found(problem.best_point, problem.best_value, evidence)


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
