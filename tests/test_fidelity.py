"""Loose selections: what they may rest on, how they are compared, and that a resumed run takes the same decisions."""

import math

import numpy as np
import pytest

import springopt as so
from springopt.errors import BudgetSpent
from springopt.fidelity import COMPARED, MEASURED_AT_FIRST, SHARE, Fidelity, Plan
from springopt.problem import Problem
from springopt.testing import Box, Tape

GRID = so.SpringLattice.grid((3, 3))
BOX = Box(np.full(GRID.spring_count, 0.5), np.full(GRID.spring_count, 10.0))
LOOSEST = 1e-3


class Astray(so.Objective):
    """An objective whose loose misfits are off by up to `error`, in another direction for each candidate."""

    error = 0.0

    def misfits(self, candidates, stage=None, tolerance=None):
        misfits, codes = super().misfits(candidates, stage, self.tolerance)
        if tolerance is not None and tolerance > self.tolerance:
            misfits = misfits + self.error * (1.0 + np.sin(1e6 * candidates[:, :1]))
        return misfits, codes


class Slightly(Astray):
    error = 1e-9


class Badly(Astray):
    error = 0.05


def make_objective(cls=so.Objective):
    cases = [
        so.LoadCase(f"{held} {force}", so.side(GRID, held), np.where(so.side(GRID, on)[:, None], force, 0.0))
        for held, on in (("left", "right"), ("bottom", "top"))
        for force in ([0.3, 0.0], [0.0, 0.3])
    ]
    reference = so.SpringReference(so.Model(GRID), 5.0)
    return cls(so.Model(GRID), cases, np.array([reference.deform(case) for case in cases]))


def make_problem(objective, tape=None, **limits):
    return Problem(objective, BOX, so.Budget(**limits or {"evaluations": 100_000}), tape, loosest_tolerance=LOOSEST)


def evolve(problem, generations=40, size=12, deviation=0.5):
    """A simple evolution, which asks for the best of parents and children; what it was answered."""
    rng, answers = np.random.default_rng(0), []
    points = problem.sample(rng, size)
    best = problem.best_of(points, size)
    parents, values = points[best.places], best.values
    for _ in range(generations):
        children = np.clip(parents + deviation * rng.standard_normal(parents.shape), problem.lower, problem.upper)
        best = problem.best_of(children, size, rivals=values)
        joined = np.concatenate([best.values, values])
        order = np.argsort(joined, kind="stable")[:size]
        parents, values = np.concatenate([children[best.places], parents])[order], joined[order]
        answers.append((best.places.tolist(), best.values.tolist()))
    return answers


def test_the_best_and_its_history_rest_on_the_scene_s_own_tolerance():
    tape, objective = Tape(), make_objective()
    problem = make_problem(objective, tape)
    evolve(problem)
    assert {answer.tolerance for answer in tape.answers} > {objective.tolerance}
    assert problem.loose_selections.made > problem.loose_selections.compared > 0
    assert problem.best_value == objective.evaluate(problem.best_point[None]).values[0]
    found = {each.value for each in problem.meter.history}
    assert found == {a.value for a in tape.answers if a.value in found and a.tolerance == objective.tolerance}


def test_a_target_is_reached_by_the_scene_s_own_tolerance():
    plain = make_problem(make_objective())
    evolve(plain)
    problem = make_problem(make_objective(), target=plain.meter.history[-3].value)
    with pytest.raises(BudgetSpent):
        evolve(problem)
    assert problem.meter.target_reached
    assert problem.best_value == make_objective().evaluate(problem.best_point[None]).values[0]


def test_right_selections_do_not_differ_and_wrong_ones_are_counted():
    slightly, badly = (make_problem(make_objective(cls)) for cls in (Slightly, Badly))
    evolve(slightly)
    evolve(badly)
    assert slightly.loose_selections.differed == 0
    assert badly.loose_selections.differed > 0


def test_errors_that_are_large_beside_the_spread_tighten_the_tolerance():
    tape = Tape()
    problem = make_problem(make_objective(Badly), tape)
    evolve(problem)
    used = {answer.tolerance for answer in tape.answers} - {problem.objective.tolerance}
    assert not used or max(used) < LOOSEST
    assert problem.loose_selections.made >= problem.loose_selections.compared


def test_solves_by_both_tolerances_count():
    problem, objective = make_problem(make_objective()), make_objective()
    problem.best_of(BOX.sample(np.random.default_rng(0), 5), 5)
    assert problem.meter.solves == 2 * 5 * len(objective.cases)
    assert problem.meter.evaluations == 5


@pytest.mark.parametrize("kept", [0, 1, 17, 100, 250, 491])
@pytest.mark.parametrize("cls", [so.Objective, Badly])
def test_a_resumed_run_takes_the_same_decisions(cls, kept):
    whole_tape = Tape()
    whole = make_problem(make_objective(cls), whole_tape)
    answers = evolve(whole)
    tape = Tape(whole_tape.answers[:kept])
    resumed = make_problem(make_objective(cls), tape)
    assert evolve(resumed) == answers
    assert [(*answer[:5], answer.payload) for answer in tape.answers] == [
        (*answer[:5], answer.payload) for answer in whole_tape.answers
    ]
    assert resumed.loose_selections == whole.loose_selections
    assert resumed.meter.solves == whole.meter.solves


def test_without_a_loosest_tolerance_nothing_is_loose():
    tape = Tape()
    problem = Problem(make_objective(), BOX, so.Budget(evaluations=1000), tape)
    evolve(problem)
    assert problem.loose_selections is None
    assert {answer.tolerance for answer in tape.answers} == {problem.objective.tolerance}


class TestPlan:
    def known(self, error, spread):
        return Fidelity(1e-8, LOOSEST, measured=MEASURED_AT_FIRST, error=error, spread=spread, loose_count=1)

    def test_the_first_selections_are_compared(self):
        assert Fidelity(1e-8, LOOSEST).plan() == Plan(LOOSEST, is_loose=True, is_compared=True, error=math.inf)

    def test_it_is_the_loosest_while_the_spread_is_wide(self):
        assert self.known(error=1e-4, spread=1.0).plan() == Plan(LOOSEST, is_loose=True, error=1e-4)

    def test_it_falls_with_the_spread(self):
        spread = 1e-3
        plan = self.known(error=1e-4, spread=spread).plan()
        assert plan.tolerance == pytest.approx(LOOSEST * SHARE * spread / 1e-4)
        assert plan.error == pytest.approx(SHARE * spread)

    @pytest.mark.parametrize("spread", [0.0, 1e-9])
    def test_it_is_the_scene_s_own_once_the_values_are_alike(self, spread):
        assert self.known(error=1e-4, spread=spread).plan() == Plan(1e-8, is_loose=False)

    def test_one_in_so_many_is_compared(self):
        fidelity, compared = self.known(error=0.0, spread=1.0), []
        for number in range(3 * COMPARED):
            fidelity.loose_count = number
            compared.append(fidelity.plan().is_compared)
        assert np.flatnonzero(compared).tolist() == [0, COMPARED, 2 * COMPARED]
