"""The stiffness that a set of load cases tells: runs in rounds, a seed each, and what they are worth in the tests."""

from __future__ import annotations

import time
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from springopt.analysis.analytic_start import NAME as ANALYTIC
from springopt.analysis.analytic_start import analytic_start
from springopt.budget import Budget
from springopt.checks import Floats
from springopt.errors import NotServed, SpringoptError
from springopt.optimizer import Optimizer, require_supplies
from springopt.options import make_optimizer
from springopt.problem import Problem
from springopt.registry import installed, load_optimizer
from springopt.rehearsal import rehearse
from springopt.run import Run
from springopt.runner import solve
from springopt.scene import Setup
from springopt.tradeoff.axes.load_cases.sets import CaseSet
from springopt.tradeoff.clock import LEAST_ROUNDS, NARROW
from springopt.tradeoff.errors import errors_of_cases
from springopt.tradeoff.interval import Interval
from springopt.tradeoff.point import Request

#: The strongest first, with what makes a run of them one identification: a single search may end in a minimum that is
#: none of the load cases' fault, and where these leave something open no two searches agree.
CHOICES: Mapping[str, Mapping[str, Any]] = {
    "gauss-newton": {"starts": 5, "agree": 2},
    "l-bfgs-b": {"starts": 5, "agree": 2},
    "paper-ga": {},
    "random-search": {},
}
#: Numbers in a Jacobian beyond which one step by it takes seconds, in which l-bfgs-b makes many.
LARGE = 10**7
LEAST_SEEDS = 2
MOST_SEEDS = 15
SHORTEST = 0.05  # seconds of a run
PATIENCE = 3  # times the share of a run whose evaluations are limited
TRIAL = 32  # candidates by which the pace is told
EVALUATIONS = 10_000  # where a scene limits none


@dataclass(frozen=True, eq=False)
class Identification:
    """One run on a set, with one seed."""

    errors: Floats  #: in each test load case, inf where there is no answer, shape (tests,)
    processor: float  #: seconds
    wall: float
    run: Run | None = None  #: None where it failed
    is_cut: bool = False  #: whether the time ended it
    why: str = ""  #: an error is inf


@dataclass(frozen=True)
class Method:
    """How stiffness is identified, on all sets alike."""

    optimizer: Optimizer
    evaluations: int | None  #: that a run may cost; None for one that ends by itself
    warm_up: float  #: seconds on the wall, before the first run
    start: str | None  #: the optimizer whose point is the first guess; None where it has none for the scene

    @property
    def said(self) -> str:
        """As in "gauss-newton from analytic (starts 5, agree 2)"."""
        options = [f"{name} {getattr(self.optimizer, name)}" for name in CHOICES[self.optimizer.name]]
        if self.evaluations is not None:
            options.append(f"{self.evaluations:,} evaluations")
        start = f" from {self.start}" if self.start else ""
        return f"{self.optimizer.name}{start} ({', '.join(options)})"


def choose_method(largest: Setup, seconds: float) -> Method:
    """The strongest installed optimizer that serves a scene; without derivatives, evaluations that fit in so long.

    Args:
        largest: the setup with the most load cases.
        seconds: on the wall, that one run on it may take.
    """
    problem = Problem(largest.objective, largest.encoding, Budget(evaluations=1))
    for name in CHOICES:
        if name not in installed() or (name == "gauss-newton" and _jacobian_size(largest) > LARGE):
            continue
        kind, stated = load_optimizer(name), largest.scene.optimizer_options(name)
        optimizer = make_optimizer(kind, {**CHOICES[name], **stated})
        begun = time.perf_counter()
        try:
            require_supplies(optimizer, problem.supplies)
            rehearse(optimizer, largest)
            # What only a run can tell, as the memory that it needs.
            solve(largest.scene, optimizer, evaluations=2, setup=largest)
        except NotServed:
            continue
        except SpringoptError:
            pass  # told when it goes wrong in the runs
        warm_up = time.perf_counter() - begun
        ends_by_itself = bool(CHOICES[name])
        evaluations = None if ends_by_itself else _affordable(largest, seconds)
        return Method(optimizer, evaluations, warm_up, None if analytic_start(largest) is None else ANALYTIC)
    raise AssertionError("random-search, which serves every scene, is the core's own")


def identify(
    sets: Sequence[CaseSet], method: Method, limits: Sequence[float], request: Request, until: float
) -> list[list[Identification]]:
    """Runs on all sets, in rounds until that time of `time.perf_counter` or until errors and times are sure.

    The first round is always complete.

    Args:
        limits: seconds on the wall of a run on each set.
    """
    found: list[list[Identification]] = [[] for _ in sets]
    rng = np.random.default_rng(request.seed)
    for round_number in range(MOST_SEEDS):
        left = [number for number, its in enumerate(found) if not _is_sure(its)]
        for number in rng.permutation(left).astype(int).tolist():
            expected = max((each.wall for each in found[number]), default=0.0)
            if round_number and time.perf_counter() + 0.5 * expected >= until:
                continue
            found[number].append(_identify(sets[number], method, limits[number], request.seed + round_number))
            if request.progress:
                words = f"{sets[number].series}, {sets[number].name}, seed {request.seed + round_number}"
                request.progress(sum(map(len, found)), LEAST_SEEDS * len(sets), words)
        if not left or time.perf_counter() >= until:
            break
    return found


def _identify(chosen: CaseSet, method: Method, limit: float, seed: int) -> Identification:
    setup = chosen.setup
    # Runs of so many evaluations are only cut where their pace was told quite wrong, or sets would differ in effort.
    limit *= 1 if method.evaluations is None else PATIENCE
    wall, processor = time.perf_counter(), time.process_time()
    try:
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", "the start .* spent the whole budget")  # a run that is cut, as said below
            run = solve(
                setup.scene,
                method.optimizer,
                start=method.start,
                seed=seed,
                seconds=limit,
                evaluations=method.evaluations,
                setup=setup,
            )
    except SpringoptError as error:
        tests = sum(case.role == "test" for case in setup.cases)
        spent = time.process_time() - processor, time.perf_counter() - wall
        return Identification(np.full(tests, np.inf), *spent, why=str(error))
    if run.why_stopped == "interrupted":
        raise KeyboardInterrupt
    is_cut = run.why_stopped == "budget" and run.seconds >= limit
    errors, why = _errors_in_tests(setup, run)
    return Identification(errors, run.processor_seconds, run.seconds, run, is_cut, why)


def _errors_in_tests(setup: Setup, run: Run) -> tuple[Floats, str]:
    """In each test load case, shape (tests,), inf where the model has no equilibrium; and which these are.

    None is below the tolerance of the forward solve, which can't tell less from zero.
    """
    numbers = [number for number, case in enumerate(setup.cases) if case.role == "test"]
    cases, known = [setup.cases[number] for number in numbers], setup.reference_positions[numbers]
    solution = setup.model.solve(setup.encoding.decode(run.point), cases, setup.objective.tolerance)
    errors = np.maximum(errors_of_cases(solution.positions, known, setup.lattice.nodes), setup.objective.tolerance)
    found = np.array([status.has_equilibrium for status in solution.status])
    lost = [f"{case.name}: {status}" for case, status in zip(cases, solution.status, strict=True)]
    why = ", ".join(words for words, is_there in zip(lost, found, strict=True) if not is_there)
    return np.where(found, errors, np.inf), why


def _jacobian_size(setup: Setup) -> int:
    training = sum(case.role == "train" for case in setup.cases)
    return training * setup.reference_positions[0].size * setup.encoding.size


def _affordable(largest: Setup, seconds: float) -> int:
    """Evaluations, as the scene allows at most, of which each set has as many."""
    candidates = largest.encoding.decode(largest.encoding.sample(np.random.default_rng(0), TRIAL))
    largest.objective.evaluate(candidates)
    begun = time.perf_counter()
    largest.objective.evaluate(candidates)
    pace = (time.perf_counter() - begun) / TRIAL
    # Half of the time is for what an optimizer does itself, and for candidates that take longer.
    return max(TRIAL, min(largest.scene.budget.evaluations or EVALUATIONS, int(0.5 * seconds / pace)))


def _is_sure(found: Sequence[Identification]) -> bool:
    if len(found) < LEAST_ROUNDS:
        return False
    times = Interval.of(each.processor for each in found)
    medians = Interval.of(float(np.median(each.errors)) for each in found)
    return times.width <= NARROW and medians.width <= NARROW
