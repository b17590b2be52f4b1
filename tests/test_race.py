"""The best of a batch: those that solving everything finds, to the bit, and in fewer solves."""

import contextlib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import springopt as so
from springopt.errors import BudgetSpent, UserError
from springopt.misfit import MISFITS
from springopt.problem import Problem
from springopt.race import Known, best_of, race
from springopt.selection import BLOCK, FIRST_PAUSE, LONGEST_PAUSE, Patience
from springopt.testing import Bowl, Box, Cliff, Tape, Unraced

GRID = so.SpringLattice.grid((3, 3))
SIDES = ("left", "right", "bottom", "top")
BOX = Box(np.zeros(GRID.spring_count), np.full(GRID.spring_count, 10.0))


def make_objective(
    case_count=5, seed=0, *, times=None, engine=None, kinematics="exact", held=SIDES, minimize="distance", **options
):
    """A grid of nine nodes that learns from equal springs, under random loads; held at random sides."""
    rng = np.random.default_rng(seed)
    effects = [so.Inertia(mass=1.0)] if times else []
    stepping = so.Stepping(0.5) if times else None
    model = so.Model(GRID, effects, kinematics=kinematics, engine=engine, stepping=stepping)
    cases = [
        so.LoadCase(str(number), so.side(GRID, rng.choice(held)), rng.normal(0, 0.1, GRID.nodes.shape), times=times)
        for number in range(case_count)
    ]
    reference = so.SpringReference(model, 5.0)
    return so.Objective(model, cases, [reference.deform(case) for case in cases], minimize, **options)


def candidates(count, seed=0, *, sparse=0.3):
    """Stiffness, some of it with equal rows, and some without an equilibrium."""
    rng = np.random.default_rng(seed)
    rows = rng.uniform(0.1, 10.0, (count, GRID.spring_count))
    rows *= rng.random((count, 1)) > np.where(rng.random(rows.shape) < sparse, sparse, -1.0)
    return rows[rng.integers(count, size=count)]


def make_problem(objective, tape=None, **limits):
    return Problem(objective, BOX, so.Budget(**limits or {"evaluations": 100_000}), tape)


def require_equal(one, other):
    np.testing.assert_array_equal(one.places, other.places)
    np.testing.assert_array_equal(one.values, other.values)


RIVALS = st.one_of(st.integers(0, 19), st.floats(0.0, 2.0), st.just(np.inf))  # a candidate's value, or a share of it


@settings(max_examples=150)
@given(
    question=st.fixed_dictionaries(
        {
            "case_count": st.integers(1, 6),
            "seed": st.integers(0, 10_000),
            "minimize": st.sampled_from(list(MISFITS)),
            "engine": st.sampled_from([None, None, "sparse"]),
            "kinematics": st.sampled_from(["exact", "exact", "linear"]),
            "held": st.sampled_from([SIDES, SIDES[:1], SIDES[:2]]),
            "cost_cap": st.sampled_from([None, 0.3, 0.05]),
        }
    ),
    weights=st.lists(st.sampled_from([0.0, 0.5, 1.0, 3.0]), min_size=5, max_size=5),
    batch=st.tuples(st.integers(1, 20), st.integers(0, 10_000), st.sampled_from([0.0, 0.3])),
    count=st.integers(1, 12),
    known=st.lists(RIVALS, max_size=12),
)
def test_the_best_are_those_of_solving_everything_to_the_bit(question, weights, batch, count, known):
    case_count = question["case_count"]
    objective = make_objective(**question, weights=[1.0, *weights][:case_count])
    points = candidates(batch[0], batch[1], sparse=batch[2])
    values = objective.evaluate(points).values
    rivals = [values[each % len(values)] if isinstance(each, int) else each * values.max() for each in known]
    problem, plain = make_problem(objective), Unraced(objective, BOX, so.Budget(evaluations=100))
    require_equal(*(each.best_of(points, count, rivals=rivals) for each in (problem, plain)))
    assert problem.best_value == plain.best_value
    np.testing.assert_array_equal(problem.best_point, plain.best_point)
    assert problem.meter.evaluations == plain.meter.evaluations
    assert problem.meter.solves <= plain.meter.solves


@pytest.mark.parametrize("engine", [None, "sparse"])
@pytest.mark.parametrize("seed", range(5))
def test_motions_are_raced_to_the_bit(seed, engine):
    objective = make_objective(4, seed, times=(0.5, 1.0), engine=engine)
    points = candidates(9, seed, sparse=0.0)
    values = objective.evaluate(points).values
    for count, rivals in ((1, ()), (3, values[:4] / 2), (9, values)):
        problem = make_problem(objective)
        require_equal(problem.best_of(points, count, rivals=rivals), best_of(values, count, np.array(rivals)))


def test_a_load_case_that_tells_enough_spares_the_others():
    objective = make_objective(4, held=SIDES[:1])
    good, bad = np.full(GRID.spring_count, 5.0), np.full(GRID.spring_count, 0.1)
    problem = make_problem(objective)
    best = problem.best_of(np.array([bad, good, bad, bad]), 1)
    assert (best.places.tolist(), best.values.tolist()) == ([1], [objective.evaluate(good[None]).values[0]])
    assert problem.meter.solves == 4 + 3  # the good one's four, and one each of the others
    assert problem.meter.evaluations == 4


def test_nothing_is_dropped_while_all_may_be_among_the_best():
    problem = make_problem(make_objective(4))
    problem.best_of(candidates(6), 6, rivals=np.full(6, np.inf))
    assert problem.meter.solves == 24


@pytest.mark.parametrize("cap", [None, 0.05])
def test_without_an_equilibrium_a_candidate_costs_at_least_the_cap(cap):
    objective = make_objective(4, cost_cap=cap)
    none, whole = np.zeros(GRID.spring_count), np.full(GRID.spring_count, 4.0)
    raced = race(objective, np.array([none, whole]), Known(1, np.array([objective.cost_cap / 2])), best=0.0)
    assert raced.values[0] == np.inf
    assert raced.solves[0] < 4
    some = race(objective, np.array([none, whole]), Known(2, np.empty(0)))
    np.testing.assert_array_equal(some.values, objective.evaluate([none, whole]).values)


def test_small_displacements_race_by_whole_sets_of_supports():
    linear, exact = (make_objective(6, held=SIDES[:1], kinematics=kind) for kind in ("linear", "exact"))
    assert [len(stage.cases) for stage in linear.stages] == [6]
    assert [len(stage.cases) for stage in exact.stages] == [2, 2, 2]


def test_an_objective_without_stages_answers_alike():
    bowl, points = Bowl(np.arange(3.0)), np.random.default_rng(0).uniform(0, 10, (9, 3))
    for objective in (bowl, Cliff(bowl, 5.0)):
        problem = Problem(objective, Box(np.zeros(3), np.full(3, 10.0)), so.Budget(evaluations=50))
        values = objective.evaluate(points).values
        require_equal(problem.best_of(points, 4, rivals=[values[0]]), best_of(values, 4, values[:1]))


def test_what_wraps_an_objective_is_not_raced_past():
    objective, points = make_objective(4), candidates(8, sparse=0.0)
    cliff = Cliff(objective, 5.0)
    assert len(cliff.stages) > 1
    require_equal(make_problem(cliff).best_of(points, 1), best_of(cliff.evaluate(points).values, 1, np.empty(0)))


@pytest.mark.parametrize(
    ("count", "rivals", "sentence"),
    [
        (0, (), "count must be a whole number from 1 on, not 0"),
        (1.0, (), r"count must be a whole number from 1 on, not 1\.0"),
        (1, [np.nan], "rivals must be numbers, not nan"),
        (1, [[1.0]], r"rivals must have the shape \(r,\)"),
    ],
)
def test_a_question_that_makes_no_sense_is_refused(count, rivals, sentence):
    with pytest.raises(UserError, match=sentence):
        make_problem(make_objective(1)).best_of(candidates(2), count, rivals=rivals)


class TestBudget:
    POINTS = candidates(10, seed=4, sparse=0.0)

    @pytest.mark.parametrize("limits", [{"evaluations": 7}, {"solves": 31}])
    def test_of_a_batch_that_crosses_it_the_part_that_fits_is_solved(self, limits):
        tape, objective = Tape(), make_objective(4)
        problem = make_problem(objective, tape, **limits)
        with pytest.raises(BudgetSpent):
            problem.best_of(self.POINTS, 1)
        assert [answer.value for answer in tape.answers] == objective.evaluate(self.POINTS[:7]).values.tolist()
        assert (problem.meter.evaluations, problem.meter.solves) == (7, 28)

    def test_solves_that_were_saved_are_left(self):
        problem = make_problem(make_objective(4), solves=80)
        for _ in range(2):
            problem.best_of(self.POINTS, 1, rivals=[problem.best_value])
        assert problem.meter.solves < 80
        assert problem.budget_left == (80 - problem.meter.solves) // 4

    @pytest.mark.parametrize("place", [0, 4, 9])
    def test_the_first_that_reaches_the_target_ends_the_run(self, place):
        objective = make_objective(4)
        values = objective.evaluate(self.POINTS).values
        problem, plain = (cls(objective, BOX, so.Budget(target=values[place])) for cls in (Problem, Unraced))
        for each in (problem, plain):
            with contextlib.suppress(BudgetSpent):
                each.best_of(self.POINTS, 1, rivals=[values.min() / 2])
            assert each.meter.target_reached
        assert problem.meter.evaluations == plain.meter.evaluations
        assert problem.best_value == plain.best_value <= values[place]

    def test_a_dropped_candidate_is_never_missed_as_the_best(self):
        objective = make_objective(4)
        values = objective.evaluate(self.POINTS).values
        problem = make_problem(objective)
        best = problem.best_of(self.POINTS, 1, rivals=[values.min() / 2])  # a rival that no point has
        assert not len(best.places)
        assert problem.best_value == values.min()


class TestReplay:
    @staticmethod
    def live(problem, seed=0):
        """A search that asks for the best again and again."""
        rng, parents, answers = np.random.default_rng(seed), np.full(3, np.inf), []
        for _ in range(6):
            best = problem.best_of(rng.uniform(0.1, 10.0, (70, GRID.spring_count)), 3, rivals=parents)
            parents = np.sort(np.concatenate([best.values, parents]))[:3]
            answers += [best.places.tolist(), best.values.tolist(), problem.budget_left]
        return answers

    @pytest.fixture
    def recorded(self):
        tape = Tape()
        problem = make_problem(make_objective(4), tape)
        answers = self.live(problem)
        return problem, list(tape.answers), answers

    def test_some_are_dropped_and_leave_no_value(self, recorded):
        problem, answers, _ = recorded
        dropped = [answer for answer in answers if answer.value is None]
        assert dropped
        assert {answer.kind for answer in dropped} == {"raced"}
        assert problem.meter.solves == sum(answer.solves(4) for answer in answers)

    @pytest.mark.parametrize("kept", [0, 1, 30, 64, 69, 70, 71, 200, 420])
    def test_from_any_answer_on_it_is_the_same_to_the_bit(self, recorded, kept):
        whole, answers, told = recorded
        tape = Tape(answers[:kept])
        resumed = make_problem(make_objective(4), tape)
        assert self.live(resumed) == told
        assert [answer[:5] for answer in tape.answers] == [answer[:5] for answer in answers]
        assert resumed.meter.solves == whole.meter.solves
        facts = [[(each.evaluations, each.solves, each.value) for each in p.meter.history] for p in (whole, resumed)]
        assert facts[0] == facts[1]

    def test_nothing_on_record_is_solved_again(self, recorded, monkeypatch):
        _, answers, told = recorded
        objective = make_objective(4)
        monkeypatch.setattr(type(objective), "misfits", None)
        assert self.live(make_problem(objective, Tape(answers))) == told


class TestPatience:
    def test_races_that_save_too_little_pause_ever_longer(self):
        patience, pauses = Patience(), []
        for _ in range(12):
            patience.learn(BLOCK, BLOCK)
            pauses.append(0)
            while not patience.is_ready(BLOCK):
                pauses[-1] += 1
        assert pauses == [min(FIRST_PAUSE * 2**number, LONGEST_PAUSE) for number in range(12)]

    def test_races_that_save_go_on(self):
        patience = Patience(pause=8)
        patience.learn(BLOCK // 2, BLOCK)
        assert patience.is_ready(BLOCK)
        assert patience.pause == 0
