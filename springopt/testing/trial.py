"""One run of an optimizer under observation: whatever it does, its checks go on."""

from __future__ import annotations

import contextlib
import math
import threading
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from threadpoolctl import threadpool_limits

from springopt.budget import Budget
from springopt.checks import Floats
from springopt.errors import BudgetSpent, UserError
from springopt.interrupt import Interrupted
from springopt.meter import Meter
from springopt.optimizer import Optimizer
from springopt.problem import Problem
from springopt.testing.tape import Tape
from springopt.testing.task import Task, all_tasks
from springopt.testing.verdict import NotJudged, told

PATIENCE = 60.0  # seconds for a few hundred evaluations that take microseconds
LATE_QUESTIONS = 1000  # that are refused before an optimizer counts as one that never ends
WHOLE = Budget(evaluations=150)


class NeverEnds(Exception):
    """An optimizer does not stop at the end of its budget, or does not move at all."""


@dataclass(frozen=True, eq=False)
class Trial:
    """What came of an attempt."""

    problem: WatchedProblem
    tape: Tape
    error: BaseException | None  #: the optimizer's own: the end of its budget is none

    @property
    def refused(self) -> bool:
        """Whether the optimizer said in one sentence, before any question, that this problem is not for it."""
        return isinstance(self.error, UserError) and not self.problem.asked

    @property
    def solves_recorded(self) -> int:
        """Equilibria that its answers took, by values or with derivatives."""
        each = sum(case.role == "train" for case in self.problem.objective.cases)
        return sum(answer.solves(each) for answer in self.tape.answers if answer.kind != "budget_left")

    @property
    def journal(self) -> list[tuple[Any, ...]]:
        """Questions and answers in order, without their seconds."""
        return [(*answer[:5], answer.payload, answer.checksum) for answer in self.tape.answers]


class WatchedProblem(Problem):
    """A problem that knows whether it was asked, and keeps who asks on and on after the end.

    Args:
        cut: evaluations after which the run is interrupted, as by Ctrl-C.
    """

    def __init__(self, task: Task, budget: Budget, tape: Tape, cut: float) -> None:
        def watch(meter: Meter) -> None:
            if meter.evaluations >= cut:
                raise Interrupted

        super().__init__(task.objective, task.encoding, budget, tape, watch=watch)
        self.over = threading.Event()
        self.asked = False
        self.late_questions = 0

    def _in_box(self, points: ArrayLike, shape: tuple[int | str, ...]) -> Floats:
        self.asked = True
        self.late_questions += self.meter.counted_room() < 1
        if self.late_questions > LATE_QUESTIONS:
            self.over.set()
            threading.Event().wait()  # for ever: who swallows BudgetSpent would swallow any exception
        return super()._in_box(points, shape)


def attempt(
    optimizer: Optimizer,
    task: Task,
    budget: Budget = WHOLE,
    *,
    seed: int = 0,
    tape: Tape | None = None,
    cut: float = math.inf,
) -> Trial:
    """Lets the optimizer run on the task, in a thread that is left alone if it never ends.

    Its linear algebra has one thread, as in a run.
    """
    tape = tape or Tape()
    problem = WatchedProblem(task, budget, tape, cut)
    errors: list[BaseException] = []

    def work() -> None:
        try:
            with contextlib.suppress(BudgetSpent, Interrupted), threadpool_limits(1, user_api="blas"):
                optimizer.minimize(problem, np.random.default_rng(seed))
        except BaseException as error:
            errors.append(error)
        problem.over.set()

    threading.Thread(target=work, daemon=True).start()
    if not problem.over.wait(PATIENCE):
        errors.append(NeverEnds(f"it did not end within {PATIENCE:g} seconds"))
    elif problem.late_questions > LATE_QUESTIONS:
        errors.append(NeverEnds(f"it went on asking after BudgetSpent, {LATE_QUESTIONS} times"))
    return Trial(problem, tape, errors[0] if errors else None)


def accepted_tasks(optimizer: Optimizer) -> list[Task]:
    """The tasks that supply what the optimizer needs, and that it does not refuse in a sentence."""
    supplied = [task for task in all_tasks() if set(optimizer.needs) <= task.supplies]
    return [task for task in supplied if not attempt(optimizer, task, Budget(evaluations=2)).refused]


def tasks_for(optimizer: Optimizer) -> list[Task]:
    """The same, for checks that can say nothing without any."""
    tasks = accepted_tasks(optimizer)
    if not tasks:
        raise NotJudged(f"{optimizer.name} refuses every problem; mend that first.")
    return tasks


def judged(trial: Trial) -> Trial:
    """The trial, unless a fault ended it that another check looks for."""
    if trial.error is not None:
        raise NotJudged(f"another fault is in the way ({told(trial.error)}); mend that first.") from trial.error
    return trial


def repeatable(optimizer: Optimizer, task: Task) -> Trial:
    """A trial that another one with the same seed repeats."""
    trials = [judged(attempt(optimizer, task)) for _ in range(2)]
    if not same(*trials):
        raise NotJudged(f"the same seed does not give {optimizer.name} the same journal; mend that first.")
    return trials[0]


def same(one: Trial, other: Trial) -> bool:
    """Whether two trials asked, heard and noted the same."""
    return one.journal == other.journal and repr(one.problem.notes) == repr(other.problem.notes)
