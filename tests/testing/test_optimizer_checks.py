"""The checks that plugin authors import find what they are for: each rogue here fails the one check of its kind."""

import contextlib
import json
import os
import re
import sys
import threading
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from springopt.budget import Budget
from springopt.errors import BudgetSpent, NoEquilibrium, UserError
from springopt.optimizer import Optimizer
from springopt.testing import NotJudged, check_optimizer, examine, optimizer_checks, trial
from springopt.testing.optimizer_checks import check_keeps_to_its_budget, check_resumes_exactly
from springopt.testing.task import all_tasks


@dataclass(frozen=True)
class Climber(Optimizer):
    """A sound optimizer that needs values alone: it varies its best point. The rogues change it."""

    name = "climber"
    batch: int = 10  #: candidates per call
    share: float = 0.2  #: of the numbers that are drawn anew

    def minimize(self, problem, rng):
        point, value = self.best_of(problem, problem.sample(rng, self.batch))
        while problem.budget_left:
            trial, trial_value = self.best_of(problem, self.vary(point, problem, rng))
            if trial_value <= value:
                point, value = trial, trial_value

    def vary(self, point, problem, rng):
        anew = rng.random((self.batch, problem.size)) < self.share
        return np.where(anew, problem.sample(rng, self.batch), point)

    def best_of(self, problem, points):
        values = problem.evaluate(points)
        return points[values.argmin()], values.min()


@dataclass(frozen=True)
class Descent(Optimizer):
    """A sound optimizer that needs gradients: projected steps from random starts, shorter where they lead astray."""

    name = "descent"
    needs = ("real", "gradient")
    step: float = 1.0  #: of the first step, as a share of the box

    def minimize(self, problem, rng):
        while problem.budget_left:
            point = problem.sample(rng, 1)[0]
            value, gradient = self.ask(problem, point)
            length = self.step * problem.upper[0]
            while problem.budget_left and length > 1e-6 * problem.upper[0] and gradient.any():
                trial = point - length * gradient / np.abs(gradient).max()
                trial = np.clip(trial, problem.lower, problem.upper)
                trial_value, trial_gradient = self.ask(problem, trial)
                if trial_value < value:
                    point, value, gradient, length = trial, trial_value, trial_gradient, 2 * length
                length /= 4

    def ask(self, problem, point):
        try:
            return problem.gradient(point)
        except NoEquilibrium:
            return np.inf, np.zeros(problem.size)


@dataclass(frozen=True)
class Formula(Optimizer):
    """A sound optimizer that needs no search: one stiffness that fits the mean displacement."""

    name = "formula"
    needs = ("objective", "real")

    def minimize(self, problem, rng):
        model = problem.objective.model
        assert problem.objective.reference_positions.shape[1:] == model.lattice.nodes.shape
        problem.evaluate(np.full((1, problem.size), 4.0))


# Rogues against the declaration.


@dataclass(frozen=True)
class Mute(Climber):
    count: int = 3
    """Not the place for an explanation."""


@dataclass(frozen=True)
class Misused(Climber):
    count: int = "three"  #: how many


@dataclass(frozen=True)
class Needy(Climber):
    needs = ("gradients",)


class Plain(Climber):
    def __init__(self):
        pass


# Rogues that do not come to an end, or to nothing.


@dataclass(frozen=True)
class Torn(Climber):
    needs = ("real", "binary")


@dataclass(frozen=True)
class Picky(Climber):
    def minimize(self, problem, rng):
        raise UserError("picky wants another scene; choose one.")


@dataclass(frozen=True)
class Lazy(Climber):
    def minimize(self, problem, rng):
        pass


@dataclass(frozen=True)
class Narrow(Climber):
    def minimize(self, problem, rng):
        _first, _second, *_ = problem.lower
        super().minimize(problem, rng)


@dataclass(frozen=True)
class Sprawling(Climber):
    def vary(self, point, problem, rng):
        return super().vary(point, problem, rng) + 1e-9


# Rogues against the budget.


@dataclass(frozen=True)
class Deaf(Climber):
    def minimize(self, problem, rng):
        while True:
            try:
                super().minimize(problem, rng)
            except BaseException as swallowed:
                swallowed.add_note("and swallowed")


@dataclass(frozen=True)
class Dozing(Climber):
    def minimize(self, problem, rng):
        with contextlib.suppress(BudgetSpent):
            super().minimize(problem, rng)
        dozing.wait()


@dataclass(frozen=True)
class Planner(Climber):
    def minimize(self, problem, rng):
        for _ in range(int(problem.budget_total)):
            self.best_of(problem, problem.sample(rng, self.batch))


@dataclass(frozen=True)
class Smuggler(Climber):
    def best_of(self, problem, points):
        if hasattr(problem.objective, "model"):
            problem.objective.evaluate(problem.encoding.decode(points))
        return super().best_of(problem, points)


# Rogues against replay.


@dataclass(frozen=True)
class Forgetful(Climber):
    def vary(self, point, problem, rng):
        return super().vary(point, problem, np.random.default_rng())


@dataclass(frozen=True)
class Remembering(Climber):
    def vary(self, point, problem, rng):
        asked.append(None)
        return super().vary(point, problem, np.random.default_rng(len(asked)))


@dataclass(frozen=True)
class Bookkeeper(Climber):
    """Keeps its point in a file, from which it goes on after it was cut short."""

    def minimize(self, problem, rng):
        book = books / f"{problem.size}.json"
        if book.exists():
            problem.evaluate([json.loads(book.read_text())])
        try:
            super().minimize(problem, rng)
        except BudgetSpent:
            book.unlink(missing_ok=True)
            raise
        book.unlink(missing_ok=True)

    def best_of(self, problem, points):
        point, value = super().best_of(problem, points)
        (books / f"{problem.size}.json").write_text(json.dumps(point.tolist()))
        return point, value


@dataclass(frozen=True)
class Crowd(Climber):
    """As many candidates at once as there are processors."""

    def minimize(self, problem, rng):
        Climber(batch=10 * os.cpu_count()).minimize(problem, rng)


@dataclass(frozen=True)
class Threaded(Climber):
    """As many candidates at once as there are threads."""

    def minimize(self, problem, rng):
        threads = problem.objective.model.threads if hasattr(problem.objective, "model") else 1
        Climber(batch=10 * threads).minimize(problem, rng)


# Rogues against failed candidates.


@dataclass(frozen=True)
class Fragile(Descent):
    def ask(self, problem, point):
        return problem.gradient(point)


@dataclass(frozen=True)
class Discouraged(Descent):
    def minimize(self, problem, rng):
        try:
            problem.gradient(problem.upper)
        except NoEquilibrium:
            return
        super().minimize(problem, rng)


@dataclass(frozen=True)
class Relative(Climber):
    """Counts in shares of the spread among its first values, which are all the same where all fail."""

    def minimize(self, problem, rng):
        first = problem.evaluate(problem.sample(rng, 16))
        if len(set(first)) == 1 < problem.size:
            raise ZeroDivisionError("there is no spread")
        super().minimize(problem, rng)


books = Path()  # where Bookkeeper keeps its files
asked: list[None] = []  # what Remembering carries over from run to run
dozing = threading.Event()  # what Dozing waits for


# A rogue that learns nothing.


@dataclass(frozen=True)
class Stubborn(Climber):
    def vary(self, point, problem, rng):
        return point[None]


@pytest.mark.parametrize("sound", [Climber, Climber(batch=7), Descent, Formula], ids=str)
def test_a_sound_optimizer_passes_as_a_class_and_made_ready(sound):
    check_optimizer(sound)


@pytest.mark.parametrize(
    ("rogue", "check", "sentence"),
    [
        (Mute, "options are documented", "option count of climber has no explanation; put one behind #:."),
        (Narrow, "runs to its end", "climber failed on a bowl of 1 number with a budget of 1 evaluations (ValueError:"),
        (Sprawling, "stays in the box", "outside its interval [0, 1]; keep to problem.lower and problem.upper."),
        (Deaf, "keeps to its budget", "it went on asking after BudgetSpent, 1000 times; let BudgetSpent pass"),
        (Planner, "keeps to its budget", "where problem.budget_total is inf (OverflowError: "),
        (Smuggler, "keeps to its budget", "climber sought 600 equilibria past the budget of a grid of 20 springs;"),
        (Forgetful, "same seed same journal", "asks other questions with the same seed; draw all randomness from rng"),
        (Bookkeeper, "resumes exactly", "does not resume exactly from the first 1 of 150 answers; let it depend on"),
        (Fragile, "survives failed candidates", "descent let NoEquilibrium through on a bowl of 6 numbers, where half"),
        (Relative, "survives failed candidates", "climber failed on a bowl of 6 numbers, where all of the candidates"),
        (Threaded, "is independent of threads", "on a grid of 20 springs with another number of threads or processors"),
        (Crowd, "is independent of threads", "choose the size of a batch by an option, not by the machine."),
        (Stubborn, "is not worse than random search", "on a bowl of 6 numbers, where random search reaches"),
    ],
)
def test_a_rogue_is_caught_by_the_one_check_of_its_kind_and_told_what_to_mend(
    rogue, check, sentence, tmp_path, monkeypatch
):
    monkeypatch.setattr(sys.modules[__name__], "books", tmp_path)
    monkeypatch.setattr(optimizer_checks, "RACE", Budget(evaluations=300))  # enough for these
    failed = {finding.check: finding.sentence for finding in examine(rogue) if finding.verdict == "failed"}
    assert list(failed) == [check]
    assert sentence in failed[check]


@pytest.mark.parametrize(
    ("rogue", "sentence"),
    [
        (Misused, "option count of climber is a whole number, not 'three'"),
        (Needy, "climber has unknown needs (gradients); the known ones are binary, real"),
        (Plain, "Plain must be a frozen dataclass"),
        (Torn, "climber refuses every problem, and needs real and binary; need only what one scene can supply."),
        (Picky, "climber refuses every problem, and needs nothing"),
        (Lazy, "climber ended without a question on a budget of 1 evaluations; ask for at least one value"),
        (Remembering, "climber asks other questions with the same seed; draw all randomness from rng"),
        (Discouraged, "descent gave up on a bowl of 6 numbers, where half of the candidates have no equilibrium"),
    ],
)
def test_other_rogues_are_told_likewise(rogue, sentence):
    with pytest.raises(AssertionError, match=re.escape(sentence)):
        check_optimizer(rogue)


def test_what_another_fault_hides_is_not_judged():
    verdicts = {finding.check: finding for finding in examine(Sprawling)}
    assert verdicts["options are documented"].verdict == "passed"
    assert verdicts["resumes exactly"].verdict == "not judged"
    assert verdicts["resumes exactly"].sentence.startswith("another fault is in the way (OutsideBox: coordinate 0")
    with pytest.raises(NotJudged, match="the same seed does not give climber the same journal; mend that first"):
        check_resumes_exactly(Forgetful)


def test_one_that_does_nothing_any_more_is_not_waited_for(monkeypatch):
    monkeypatch.setattr(trial, "PATIENCE", 0.2)
    monkeypatch.setattr(optimizer_checks, "tasks_for", lambda optimizer: all_tasks()[:1])
    with pytest.raises(
        AssertionError, match=r"climber does not end on a bowl of 6 numbers: it did not end within 0\.2"
    ):
        check_keeps_to_its_budget(Dozing)
    dozing.set()
