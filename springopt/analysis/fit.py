"""The best point of a scene that some seconds find: a fit, where a floor would take its time.

By gauss-newton where it is installed, else by the descents that floors are found by; by gradients alone where a
Jacobian would be large, and by the first of `BINARY` that is installed where points are bits.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from threadpoolctl import threadpool_limits

from springopt.analysis.descent import distance_optimum, gradient_optimum, least_squares_optimum
from springopt.budget import Budget
from springopt.checks import Floats
from springopt.errors import BudgetSpent, NoEquilibrium
from springopt.front import Front
from springopt.optimizer import Optimizer, require_supplies
from springopt.options import make_optimizer
from springopt.problem import Problem
from springopt.random_search import RandomSearch
from springopt.registry import installed, load_optimizer
from springopt.rehearsal import rehearse
from springopt.scene import Setup

GAUSS_NEWTON = "gauss-newton"
BINARY = ("paper-ga", "random-search")  # the better one first
SAMPLES = 8  # of which the best is a start
#: Numbers in a Jacobian by points, for each second that there is: steps by larger ones are too few to be of use.
LARGE, LEAST_LARGE = 50_000, 50_000
BY_STIFFNESS = 20  # times that for the Jacobian by stiffness, from which it is made
LEAST_SECONDS = 0.05  # of a budget, which is never nothing


@dataclass(frozen=True, eq=False)
class Fit:
    """What was found, and for how much."""

    point: Floats  #: shape (size,)
    value: float  #: in the scene's own misfit
    seconds: float  #: on the wall
    is_cut: bool  #: whether the time ended it
    method: str
    front: Front  #: of springs and value, where the optimizer asked for both


def fit(
    setup: Setup,
    seconds: float,
    *,
    seed: int = 0,
    start: Floats | None = None,
    optimizer: Optimizer | None = None,
) -> Fit:
    """The best point that is found in so many seconds on the wall; always one, with an equilibrium or without.

    Args:
        setup: the scene.
        seconds: no question is asked after them; the one that is being answered ends.
        seed: of all that is drawn.
        start: a first guess, shape (size,); by default the best of some samples and of the middle of the box.
        optimizer: instead of the one that is chosen. What it refuses is a UserError.
    """
    optimizer = optimizer or _chosen(setup, seconds)
    if optimizer is not None:
        rehearse(optimizer, setup)
    begun, rng = time.perf_counter(), np.random.default_rng(seed)
    problem = Problem(setup.objective, setup.encoding, Budget(seconds=max(seconds, LEAST_SECONDS)))
    method, search = _search(setup, problem, optimizer, seconds)
    is_cut = True
    with threadpool_limits(1, user_api="blas"):
        try:
            problem.start_at(_first(problem, rng) if start is None else _asked(problem, start))
            search(problem, rng)
            is_cut = False
        except BudgetSpent:
            pass
        except NoEquilibrium:  # nor can a derivative be had then: the best of what was asked is the answer
            is_cut = False
    if problem.best_point is None:  # the time was up before the first question
        point = setup.encoding.upper if start is None else start
        value = float(setup.objective.evaluate(setup.encoding.decode(point)[None]).values[0])
        return Fit(point, value, time.perf_counter() - begun, True, method, Front())
    return Fit(problem.best_point, problem.best_value, time.perf_counter() - begun, is_cut, method, problem.front)


def warm_up(setups: Sequence[Setup]) -> None:
    """What the first fits of a process would pay for all: imports, and kernels that are compiled, once each."""
    done = set()
    for setup in setups:
        part = (setup.encoding.kind, *sorted({group.choice.engine for group in setup.model.groups(setup.cases)}))
        if part in done:
            continue
        done.add(part)
        rehearse(_chosen(setup, math.inf) or RandomSearch(), setup)
        if setup.encoding.differentiable:
            with suppress(NoEquilibrium):
                setup.objective.gradient(setup.encoding.decode(setup.encoding.upper))


def _chosen(setup: Setup, seconds: float) -> Optimizer | None:
    """The optimizer for a scene; None where a descent of our own is the better choice, or the only one."""
    if setup.encoding.kind == "binary":
        return _named(next(name for name in BINARY if name in installed()), setup)
    return None if _is_large(setup, seconds) or GAUSS_NEWTON not in installed() else _named(GAUSS_NEWTON, setup)


def _is_large(setup: Setup, seconds: float) -> bool:
    residuals = sum(case.role == "train" for case in setup.cases) * setup.reference_positions[0].size
    size = max(setup.encoding.size, setup.lattice.spring_count / BY_STIFFNESS)
    return residuals * size > max(LEAST_LARGE, LARGE * seconds)


def _search(
    setup: Setup, problem: Problem, optimizer: Optimizer | None, seconds: float
) -> tuple[str, Callable[[Problem, np.random.Generator], None]]:
    """The name of a search, and the search."""
    if optimizer is not None:
        require_supplies(optimizer, problem.supplies)
        return optimizer.name, optimizer.minimize
    if _is_large(setup, seconds):
        return "L-BFGS-B", _go_down
    dimension = setup.lattice.dimension

    def descend(problem: Problem, rng: np.random.Generator) -> None:
        distance_optimum(problem, least_squares_optimum(problem, _start(problem, rng)), dimension)

    return "descents", descend


def _named(name: str, setup: Setup) -> Optimizer:
    """With the options that the scene states."""
    return make_optimizer(load_optimizer(name), setup.scene.optimizer_options(name))


def _go_down(problem: Problem, rng: np.random.Generator) -> None:
    gradient_optimum(problem, _start(problem, rng))


def _start(problem: Problem, rng: np.random.Generator) -> Floats:
    return problem.sample(rng, 1)[0]


def _first(problem: Problem, rng: np.random.Generator) -> Floats:
    """The middle of the box is asked alone: its answer tells how many more the time allows."""
    middle = problem.upper if problem.kind == "binary" else (problem.lower + problem.upper) / 2
    points = np.stack([middle, *problem.sample(rng, SAMPLES)])
    values = [problem.evaluate(part) for part in (points[:1], points[1:])]
    return points[int(np.argmin(np.concatenate(values)))]


def _asked(problem: Problem, start: Floats) -> Floats:
    """The start, whose value counts whatever the search makes of it."""
    problem.evaluate(start[None])
    return start
