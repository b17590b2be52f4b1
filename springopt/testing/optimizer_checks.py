"""The checks that every optimizer must pass, on problems that cost nothing.

Each takes an optimizer, or its class to be checked with its defaults, and raises AssertionError with one sentence.
A plugin's whole test is `check_optimizer(MyOptimizer)`, or `pytest.mark.parametrize("check", CHECKS)` over them.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Iterator
from typing import Literal

import numpy as np

from springopt.budget import Budget
from springopt.errors import BudgetSpent, NoEquilibrium, UserError
from springopt.optimizer import NEEDS, Optimizer, require_supplies
from springopt.options import make_optimizer, options_of
from springopt.problem import Problem
from springopt.testing.bowl import Bowl, Box
from springopt.testing.tape import Tape

Kind = Literal["real", "binary"]
Check = Callable[["type[Optimizer] | Optimizer"], None]

EVALUATIONS = 150
SIZE = 6


def check_optimizer(optimizer: type[Optimizer] | Optimizer) -> None:
    """All checks, on every kind of problem that the optimizer does not refuse."""
    for check in CHECKS:
        check(optimizer)


def check_options_are_documented(optimizer: type[Optimizer] | Optimizer) -> None:
    """It has a name and known needs, and every option a type, a legal default and an explanation behind `#:`."""
    cls = optimizer if isinstance(optimizer, type) else type(optimizer)
    frozen = "__dataclass_params__" in vars(cls) and cls.__dataclass_params__.frozen  # type: ignore[attr-defined]
    _require(frozen, f"{cls.__name__} must be a frozen dataclass: decorate it with @dataclass(frozen=True).")
    _require(isinstance(getattr(cls, "name", None), str), f"{cls.__name__} has no name; give it a class attribute.")
    _require(set(cls.needs) <= set(NEEDS), f"{cls.name} has unknown needs {set(cls.needs) - set(NEEDS)}.")
    for option in options_of(cls):
        _require(bool(option.explanation), f"option {option.name} of {cls.name} has no explanation; put one behind #:.")
        try:
            make_optimizer(cls, {option.name: option.default})
        except UserError as error:
            raise AssertionError(f"the default of option {option.name} of {cls.name} is illegal: {error}") from error


def check_finishes_at_the_budget(optimizer: type[Optimizer] | Optimizer) -> None:
    """It ends when the evaluations are spent, also when a single one is, and asks at least once."""
    for ready, kind in _tasks(optimizer):
        for evaluations in (1, 2, EVALUATIONS):
            problem = _solved(ready, kind, budget=Budget(evaluations=evaluations))
            asked_too_dear = evaluations == 1 and {"gradient", "jacobian"} & set(ready.needs)
            _require(
                problem.meter.evaluations > 0 or bool(asked_too_dear),
                f"{ready.name} ended without a question on a budget of {evaluations} evaluations.",
            )


def check_finishes_in_time(optimizer: type[Optimizer] | Optimizer) -> None:
    """It ends when the time is spent, with a number of evaluations that nobody knows beforehand."""
    for ready, kind in _tasks(optimizer):
        _solved(ready, kind, budget=Budget(seconds=0.05))


def check_same_seed_same_answers(optimizer: type[Optimizer] | Optimizer) -> None:
    """It draws from `rng` alone: the same seed asks the same questions."""
    for ready, kind in _tasks(optimizer):
        tapes = [Tape(), Tape()]
        for tape in tapes:
            _solved(ready, kind, tape=tape)
        first, second = tapes
        _require(
            _questions(first) == _questions(second),
            f"{ready.name} asks other questions with the same seed; draw from rng alone.",
        )


def check_stays_in_the_box(optimizer: type[Optimizer] | Optimizer) -> None:
    """It keeps to the box where the best point lies on its border, also in one dimension."""
    for ready, kind in _tasks(optimizer):
        for size in (1, SIZE):
            _solved(ready, kind, size=size)


def check_survives_no_equilibrium(optimizer: type[Optimizer] | Optimizer) -> None:
    """It goes on after `NoEquilibrium`, and where most of the box has the same high value."""
    for ready, kind in _tasks(optimizer):
        for share in (0.5, -1.0):
            try:
                _solved(ready, kind, cliff=share)
            except NoEquilibrium:
                raise AssertionError(f"{ready.name} let NoEquilibrium through; catch it and try elsewhere.") from None


def check_resumes_exactly(optimizer: type[Optimizer] | Optimizer) -> None:
    """Given the first answers again it asks the same questions, and ends where the uninterrupted run did."""
    for ready, kind in _tasks(optimizer):
        whole = Tape()
        problem = _solved(ready, kind, tape=whole)
        for share in (0.0, 0.3, 0.9):
            tape = Tape(whole.answers[: math.ceil(share * len(whole.answers))])
            resumed = _solved(ready, kind, tape=tape)
            same = not tape.diverged and _questions(tape) == _questions(whole)
            _require(
                same and resumed.best_value == problem.best_value,
                f"{ready.name} does not resume exactly; let it depend on its seed and the answers alone.",
            )


CHECKS: tuple[Check, ...] = (
    check_options_are_documented,
    check_finishes_at_the_budget,
    check_finishes_in_time,
    check_same_seed_same_answers,
    check_stays_in_the_box,
    check_survives_no_equilibrium,
    check_resumes_exactly,
)


def _tasks(optimizer: type[Optimizer] | Optimizer) -> Iterator[tuple[Optimizer, Kind]]:
    """The optimizer made ready, with each kind of problem that its needs allow."""
    ready = make_optimizer(optimizer) if isinstance(optimizer, type) else optimizer
    kinds: list[Kind] = [kind for kind in ("real", "binary") if not set(ready.needs) & {"real", "binary"} - {kind}]
    _require(bool(kinds), f"{ready.name} needs both a real and a binary encoding, and none is both; drop one need.")
    yield from ((ready, kind) for kind in kinds)


def _solved(
    optimizer: Optimizer,
    kind: Kind,
    *,
    size: int = SIZE,
    cliff: float = math.inf,
    budget: Budget | None = None,
    tape: Tape | None = None,
) -> Problem:
    """A problem after the optimizer was at work on it; the cliff is a share of the first number's interval."""
    if kind == "real":
        box, center = Box(np.zeros(size), np.full(size, 10.0)), np.linspace(-2.0, 12.0, size)
    else:
        box, center = Box(np.zeros(size), np.ones(size), kind), np.arange(size, dtype=float) % 2
    bowl = Bowl(center, cliff=cliff * float(box.upper[0]))
    problem = Problem(bowl, box, budget or Budget(evaluations=EVALUATIONS), tape)
    require_supplies(optimizer, problem.supplies)
    try:
        with contextlib.suppress(BudgetSpent):
            optimizer.minimize(problem, np.random.default_rng(0))
    except UserError as error:
        raise AssertionError(f"{optimizer.name} on a {kind} problem with {size} unknowns: {error}") from error
    return problem


def _questions(tape: Tape) -> list[tuple[str, bytes]]:
    return [(answer.kind, answer.question) for answer in tape.answers]


def _require(claim: bool, sentence: str) -> None:
    if not claim:
        raise AssertionError(sentence)
