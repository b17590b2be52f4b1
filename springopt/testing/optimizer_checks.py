"""The checks that every optimizer must pass, on small problems that take a few seconds together.

Each takes an optimizer, or its class to be checked with its defaults, and raises AssertionError with a sentence that
says what to mend. Each looks for one fault: where another one is in its way, it raises NotJudged. A plugin's whole
test is `check_optimizer(MyOptimizer)`, or `pytest.mark.parametrize("check", CHECKS)` over them.
"""

from __future__ import annotations

import math
import os
from dataclasses import replace
from functools import cache
from unittest import mock

import numpy as np

from springopt.budget import Budget
from springopt.errors import NoEquilibrium, OutsideBox, UserError
from springopt.optimizer import NEEDS, Optimizer
from springopt.options import make_optimizer, options_of
from springopt.random_search import RandomSearch
from springopt.testing.cliff import Cliff
from springopt.testing.tape import Tape
from springopt.testing.task import Task
from springopt.testing.trial import NeverEnds, Trial, accepted_tasks, attempt, judged, repeatable, same, tasks_for
from springopt.testing.verdict import Check, Finding, NotJudged, Subject, as_in_a_run, find, require, told

SEEDS = range(5)
RACE = Budget(evaluations=500)  # against random search
PREFIXES = (0, 1, 2, 5, 21, 89)  # answers that a resumed run is given, beside all and all but one


def check_optimizer(optimizer: Subject) -> None:
    """All checks, on every kind of problem that the optimizer does not refuse."""
    for check in CHECKS:
        check(optimizer)


def examine(optimizer: Subject) -> list[Finding]:
    """What each check finds, in their order: to be read, where `check_optimizer` raises the first fault."""
    return [find(check, optimizer) for check in CHECKS]


@as_in_a_run
def check_options_are_documented(optimizer: Subject) -> None:
    """A frozen dataclass with a name and known needs; every option has a type, a legal default and an explanation."""
    cls = optimizer if isinstance(optimizer, type) else type(optimizer)
    frozen = "__dataclass_params__" in vars(cls) and cls.__dataclass_params__.frozen  # type: ignore[attr-defined]
    require(frozen, f"{cls.__name__} must be a frozen dataclass: decorate it with @dataclass(frozen=True).")
    require(isinstance(getattr(cls, "name", None), str), f"{cls.__name__} has no name; give it a class attribute.")
    unknown = ", ".join(sorted(set(cls.needs) - set(NEEDS)))
    require(not unknown, f"{cls.name} has unknown needs ({unknown}); the known ones are {', '.join(NEEDS)}.")
    for option in options_of(cls):
        require(bool(option.explanation), f"option {option.name} of {cls.name} has no explanation; put one behind #:.")
        try:
            make_optimizer(cls, {option.name: option.default})
        except UserError as error:
            raise AssertionError(f"the default of option {option.name} of {cls.name} is illegal: {error}") from error


@as_in_a_run
def check_runs_to_its_end(optimizer: Subject) -> None:
    """It fails on no problem that it accepts, down to a single number or bit, and asks at least one question."""
    ready = _ready(optimizer)
    tasks = accepted_tasks(ready)
    require(
        bool(tasks) or not set(ready.needs) <= set(NEEDS),
        f"{ready.name} refuses every problem, and needs {' and '.join(ready.needs) or 'nothing'}; "
        "need only what one scene can supply.",
    )
    for task in tasks:
        for evaluations in (1, 2, 150):
            trial = attempt(ready, task, Budget(evaluations=evaluations))
            if not isinstance(trial.error, OutsideBox | NeverEnds):
                _require_no_error(ready, trial, f"on {task.title} with a budget of {evaluations} evaluations")
            too_dear = evaluations == 1 and {"gradient", "jacobian"} & set(ready.needs)
            require(
                trial.problem.asked or bool(too_dear),
                f"{ready.name} ended without a question on a budget of {evaluations} evaluations; "
                "ask for at least one value, so that there is a result.",
            )


@as_in_a_run
def check_stays_in_the_box(optimizer: Subject) -> None:
    """It asks for points between `problem.lower` and `problem.upper` alone, also where the best one is at their end."""
    ready = _ready(optimizer)
    for task in tasks_for(ready):
        trial = attempt(ready, task)
        require(not isinstance(trial.error, OutsideBox), f"{ready.name} left the box of {task.title}: {trial.error}")
        judged(trial)


@as_in_a_run
def check_keeps_to_its_budget(optimizer: Subject) -> None:
    """It ends when evaluations or time are spent, whatever it is then doing, and solves nothing past the problem."""
    ready = _ready(optimizer)
    for task in tasks_for(ready):
        before = task.equilibria_sought
        trial = attempt(ready, task)
        require(
            not isinstance(trial.error, NeverEnds),
            f"{ready.name} does not end on {task.title}: {trial.error}; let BudgetSpent pass, which `except Exception` "
            "does and `except BaseException` does not, and come to an end also if nothing improves.",
        )
        judged(trial)
        uncounted = task.equilibria_sought - before - trial.solves_recorded
        require(
            uncounted <= 0,
            f"{ready.name} sought {uncounted} equilibria past the budget of {task.title}; "
            "read what problem.objective says, but ask for values by problem.evaluate, gradient or jacobian.",
        )
        timed = attempt(ready, task, Budget(seconds=0.05))
        if timed.error is not None:
            raise AssertionError(
                f"{ready.name} failed on {task.title} under a limit of time alone, where problem.budget_total is inf "
                f"({told(timed.error)}); go by problem.budget_left, or until BudgetSpent."
            ) from timed.error


@as_in_a_run
def check_same_seed_same_journal(optimizer: Subject) -> None:
    """It draws from `rng` alone: the same seed asks the same questions in the same order."""
    ready = _ready(optimizer)
    for task in tasks_for(ready):
        trials = [judged(attempt(ready, task)) for _ in range(2)]
        require(
            same(*trials),
            f"{ready.name} asks other questions with the same seed; draw all randomness from rng (seed foreign "
            "libraries from it), and keep nothing from run to run.",
        )


@as_in_a_run
def check_resumes_exactly(optimizer: Subject) -> None:
    """Cut anywhere and given the answers so far, it asks the same questions again and ends as the uninterrupted run."""
    ready = _ready(optimizer)
    for task in tasks_for(ready):
        whole = repeatable(ready, task)
        count = len(whole.tape.answers)
        for kept in sorted({*(kept for kept in (*PREFIXES, count - 1) if 0 <= kept < count), count}):
            attempt(ready, task, cut=kept)
            tape = Tape(whole.tape.answers[:kept])
            resumed = attempt(ready, task, tape=tape)
            require(
                not tape.diverged and same(resumed, whole),
                f"{ready.name} on {task.title} does not resume exactly from the first {kept} of {count} answers; let "
                "it depend on rng and the answers alone: no clock, no file or memory of its own from the run before.",
            )


@as_in_a_run
def check_survives_failed_candidates(optimizer: Subject) -> None:
    """It goes on after values at the cap and after `NoEquilibrium`, where half the candidates fail or all of them."""
    ready = _ready(optimizer)
    for task in tasks_for(ready):
        judged(attempt(ready, task))
        for share in (0.5, -1.0):
            edge = share * float(task.encoding.decode(task.encoding.upper)[0])
            trial = attempt(ready, replace(task, objective=Cliff(task.objective, edge)))
            where = f"on {task.title}, where {'half' if share > 0 else 'all'} of the candidates have no equilibrium"
            require(
                not isinstance(trial.error, NoEquilibrium),
                f"{ready.name} let NoEquilibrium through {where}; catch it and try elsewhere.",
            )
            _require_no_error(ready, trial, where)
            require(
                math.isfinite(trial.problem.best_value) or share < 0 or not trial.problem.asked,
                f"{ready.name} gave up {where}, without a single value; after NoEquilibrium try elsewhere.",
            )


@as_in_a_run
def check_is_independent_of_threads(optimizer: Subject) -> None:
    """It asks the same questions whether one thread solves or two, and however many processors there are."""
    ready = _ready(optimizer)
    for task in tasks_for(ready):
        with mock.patch.object(os, "cpu_count", return_value=1):
            one = repeatable(ready, task.with_threads(1))
        with mock.patch.object(os, "cpu_count", return_value=2):
            two = judged(attempt(ready, task.with_threads(2)))
        require(
            same(one, two),
            f"{ready.name} asks other questions on {task.title} with another number of threads or processors; "
            "choose the size of a batch by an option, not by the machine.",
        )


@as_in_a_run
def check_is_not_worse_than_random_search(optimizer: Subject) -> None:
    """The median of five seeds is at most that of random search after as many evaluations."""
    ready = _ready(optimizer)
    for task in tasks_for(ready):
        if task.size == 1:
            continue  # where random search is good enough
        trials = [judged(attempt(ready, task, RACE, seed=seed)) for seed in SEEDS]
        own = float(np.median([_own_value(trial) for trial in trials]))
        spent = [trial.problem.meter.evaluations for trial in trials]
        random = float(np.median([_random_value(task, spent[seed], seed) for seed in SEEDS]))
        require(
            own <= random,
            f"{ready.name} reaches {own:.4g} on {task.title}, where random search reaches {random:.4g} by as many "
            "evaluations (medians of five seeds); look for what keeps it from using the answers that it gets.",
        )


CHECKS: tuple[Check, ...] = (
    check_options_are_documented,
    check_runs_to_its_end,
    check_stays_in_the_box,
    check_keeps_to_its_budget,
    check_same_seed_same_journal,
    check_resumes_exactly,
    check_survives_failed_candidates,
    check_is_independent_of_threads,
    check_is_not_worse_than_random_search,
)


def _ready(optimizer: Subject) -> Optimizer:
    if isinstance(optimizer, Optimizer):
        return optimizer
    try:
        return make_optimizer(optimizer)
    except Exception as error:
        raise NotJudged(f"{optimizer.__name__} can't be made with its defaults ({told(error)}).") from error


def _own_value(trial: Trial) -> float:
    if not trial.problem.meter.evaluations:
        raise NotJudged("it ended without a question; mend that first.")
    return trial.problem.best_value


@cache
def _random_value(task: Task, evaluations: int, seed: int) -> float:
    """What random search reaches by so many evaluations."""
    return attempt(RandomSearch(), task, Budget(evaluations=evaluations), seed=seed).problem.best_value


def _require_no_error(optimizer: Optimizer, trial: Trial, where: str) -> None:
    if trial.error is not None:
        raise AssertionError(
            f"{optimizer.name} failed {where} ({told(trial.error)}); mend it, or refuse such a problem by a UserError "
            "before the first question."
        ) from trial.error
