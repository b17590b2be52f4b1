"""The problem and the ledger under it, on an objective without physics."""

import dataclasses
import math
import time

import numpy as np
import pytest

from springopt.budget import Budget
from springopt.errors import BudgetSpent, NoEquilibrium, OutsideBox, RecordBroken, SpringoptError, UserError
from springopt.ledger import CHUNK
from springopt.meter import Times
from springopt.problem import Problem
from springopt.testing import Bowl, Box, Cliff, Tape

SIZE = 3
CENTER = np.array([1.0, 2.0, 3.0])


def make_problem(tape=None, *, bowl=None, box=None, watch=None, **limits):
    bowl = bowl or Bowl(CENTER)
    box = box or Box(np.zeros(SIZE), np.full(SIZE, 10.0))
    return Problem(bowl, box, Budget(**limits or {"evaluations": 1000}), tape, watch=watch)


def points(count, seed=0):
    return np.random.default_rng(seed).uniform(0.0, 10.0, (count, SIZE))


class TestAnswers:
    def test_values_are_those_of_the_objective_in_their_order(self):
        asked = points(3 * CHUNK + 1)
        np.testing.assert_array_equal(make_problem().evaluate(asked), Bowl(CENTER).evaluate(asked).values)

    def test_an_empty_batch_has_no_values_and_costs_nothing(self):
        problem = make_problem()
        assert problem.evaluate(np.empty((0, SIZE))).shape == (0,)
        assert problem.meter.evaluations == 0

    def test_gradient_residuals_and_jacobian_agree(self):
        problem, point = make_problem(), points(1)[0]
        value, gradient = problem.gradient(point)
        residuals, jacobian = problem.jacobian(point)
        np.testing.assert_array_equal(residuals, problem.residuals(point))
        np.testing.assert_allclose(gradient, jacobian.T @ residuals)
        assert value == pytest.approx(0.5 * residuals @ residuals)

    def test_objectives_are_the_value_and_the_number_of_springs(self):
        goals = make_problem().objectives([[1.0, 2.0, 3.0], [1.0, 0.0, 0.0]])
        np.testing.assert_allclose(goals, [[0.0, 3.0], [6.5, 1.0]])

    def test_an_optimizer_that_writes_into_what_it_got_changes_nothing(self):
        problem, point = make_problem(), CENTER.copy()
        problem.evaluate(point[None])
        point[:] = 9.0
        problem.best_point[:] = 9.0
        np.testing.assert_array_equal(problem.best_point, CENTER)
        with pytest.raises(ValueError, match="read-only"):
            problem.lower[0] = -1.0

    def test_a_nan_of_the_objective_never_reaches_the_optimizer(self):
        with pytest.raises(SpringoptError, match="a value that is not finite"):
            make_problem(bowl=Bowl(np.array([np.nan, 0, 0]))).evaluate(points(2))
        with pytest.raises(SpringoptError, match="a gradient that is not finite"):
            make_problem(bowl=Bowl(np.array([np.nan, 0, 0]))).gradient(points(1)[0])


class TestStart:
    def test_it_is_the_first_point_of_the_first_draw_alone(self):
        plain, begun = make_problem(), make_problem()
        assert plain.start is None
        begun.start_at(CENTER)
        np.testing.assert_array_equal(begun.start, CENTER)
        (left, right), rows = (np.random.default_rng(1) for _ in range(2)), (0, 2, 3)
        drawn = [(plain.sample(left, rows_), begun.sample(right, rows_)) for rows_ in rows]
        np.testing.assert_array_equal(drawn[1][1], [CENTER, drawn[1][0][1]])
        np.testing.assert_array_equal(*drawn[2])

    def test_it_lies_in_the_box(self):
        with pytest.raises(UserError, match="coordinate 0 of"):
            make_problem().start_at(CENTER + 20.0)


class TestRefusals:
    @pytest.mark.parametrize("shape", [(SIZE,), (2, SIZE + 1), (2, 2, SIZE)])
    def test_points_of_another_shape(self, shape):
        with pytest.raises(UserError, match=r"an optimizer's points must have the shape \(m, 3\)"):
            make_problem().evaluate(np.ones(shape))

    @pytest.mark.parametrize("number", [-1e-9, 10.1, np.nan, np.inf])
    def test_a_point_outside_the_box_names_its_coordinate(self, number):
        asked = points(4)
        asked[2, 1] = number
        with pytest.raises(UserError, match=r"coordinate 1 of .* point is .*, outside its interval \[0, 10\]"):
            make_problem().evaluate(asked)
        with pytest.raises(UserError, match="coordinate 1 of"):
            make_problem().gradient(asked[2])

    def test_a_fraction_of_a_bit(self):
        with pytest.raises(OutsideBox, match=r"holds 0\.5, and a binary encoding takes 0 and 1 alone; round it"):
            make_problem(box=Box(np.zeros(SIZE), np.ones(SIZE), "binary")).evaluate(np.full((2, SIZE), 0.5))

    def test_an_encoding_without_derivatives_supplies_none(self):
        problem = make_problem(box=Box(np.zeros(SIZE), np.ones(SIZE), "binary"))
        assert problem.supplies == {"binary"}
        for ask in (problem.gradient, problem.residuals, problem.jacobian):
            with pytest.raises(UserError, match="derivatives need an encoding that has them"):
                ask(np.ones(SIZE))


class TestBudget:
    def test_a_batch_that_crosses_the_budget_is_answered_as_far_as_it_fits(self):
        tape, asked = Tape(), points(10)
        problem = make_problem(tape, evaluations=7)
        with pytest.raises(BudgetSpent):
            problem.evaluate(asked)
        assert [answer.value for answer in tape.answers] == Bowl(CENTER).evaluate(asked[:7]).values.tolist()
        assert (problem.meter.evaluations, problem.budget_left) == (7, 0)

    def test_a_spent_budget_raises_at_every_question(self):
        problem = make_problem(evaluations=2)
        problem.evaluate(points(2))
        for ask in (lambda: problem.evaluate(points(1)), lambda: problem.gradient(CENTER)):
            with pytest.raises(BudgetSpent):
                ask()

    def test_budget_spent_passes_an_except_exception(self):
        assert not issubclass(BudgetSpent, Exception)

    def test_derivatives_cost_as_much_as_the_value_and_residuals_nothing_more(self):
        problem = make_problem(evaluations=6)
        problem.gradient(CENTER)
        problem.jacobian(CENTER)
        problem.residuals(CENTER)
        assert (problem.meter.evaluations, problem.meter.solves) == (5, 5)
        with pytest.raises(BudgetSpent):
            problem.gradient(CENTER)
        assert problem.budget_left == 1

    def test_solves_are_counted_by_training_load_case(self):
        train, test = Bowl(CENTER).cases[0], type("Case", (), {"role": "test"})
        problem = make_problem(bowl=Bowl(CENTER, cases=(train, test, train)), solves=5)
        assert problem.budget_left == 2
        with pytest.raises(BudgetSpent):
            problem.evaluate(points(3))
        assert (problem.meter.evaluations, problem.meter.solves) == (2, 4)

    def test_the_run_ends_at_the_candidate_that_reaches_the_target(self):
        problem = make_problem(target=1e-3)
        asked = np.vstack([points(3), CENTER, points(2 * CHUNK)])
        with pytest.raises(BudgetSpent):
            problem.evaluate(asked)
        assert (problem.meter.evaluations, problem.best_value) == (4, 0.0)
        assert problem.meter.target_reached
        assert problem.budget_left == 0

    def test_under_a_target_alone_the_budget_has_no_end(self):
        problem = make_problem(target=0.0)
        assert problem.budget_left == problem.budget_total == math.inf

    def test_time_ends_a_run_between_two_chunks(self):
        tape = Tape()
        problem = make_problem(tape, seconds=100.0)
        problem.evaluate(points(1))
        problem.meter.clock.set(Times(100.0, 50.0, 40.0))
        with pytest.raises(BudgetSpent):
            problem.evaluate(points(1))
        assert (len(tape.answers), problem.meter.evaluations, problem.budget_left) == (1, 1, 0)

    def test_under_a_time_limit_the_budget_left_is_estimated_from_the_pace(self):
        problem = make_problem(Tape(), seconds=100.0)
        assert problem.budget_left == math.inf
        problem.evaluate(points(40))
        problem.meter.clock.set(Times(20.0, 20.0, 10.0))
        assert problem.budget_left == pytest.approx(160, abs=2)
        assert isinstance(problem.budget_left, int)


def course(problem):
    """Each improvement, without times."""
    return [(each.evaluations, each.solves, each.value) for each in problem.meter.history]


def spin(seconds):
    """Keeps the processor busy."""
    end = time.process_time() + seconds
    while time.process_time() < end:
        pass


class TestBest:
    def test_the_best_and_each_improvement_are_remembered(self):
        problem = make_problem()
        values = problem.evaluate(points(200))
        best = np.minimum.accumulate(values)
        improved = np.flatnonzero(values == best)
        history = problem.meter.history
        assert course(problem) == [(i + 1, i + 1, values[i]) for i in improved]
        assert sorted(each.processor_seconds for each in history) == [each.processor_seconds for each in history]
        assert problem.best_value == values.min()
        np.testing.assert_array_equal(problem.best_point, points(200)[values.argmin()])

    def test_solving_is_told_from_the_optimizers_own_time(self):
        problem = make_problem()
        problem.evaluate(points(200))
        spin(0.05)
        times = problem.meter.clock.read()
        assert 0.0 < times.solving_seconds < times.processor_seconds - 0.04

    def test_a_gradient_can_be_the_best(self):
        problem = make_problem()
        problem.gradient(CENTER)
        assert [(each.evaluations, each.value) for each in problem.meter.history] == [(2, 0.0)]

    def test_before_the_first_answer_there_is_none(self):
        assert make_problem().best_point is None
        assert make_problem().best_value == math.inf

    @pytest.mark.parametrize("name", ["", "step/size", ".", "a\0b"])
    def test_a_note_needs_a_word_for_a_name(self, name):
        problem = make_problem()
        with pytest.raises(UserError, match="a note's name is a word"):
            problem.note(**{name: 1.0})
        assert problem.notes == {}

    def test_notes_are_kept_beside_the_evaluations(self):
        problem = make_problem()
        problem.note(rate=1.0, temperature=5)
        problem.evaluate(points(4))
        problem.note(rate=0.5)
        assert problem.notes == {"rate": [(0, 1.0), (4, 0.5)], "temperature": [(0, 5.0)]}


class TestFront:
    """What `objectives` found: bits of which two are wanted, none where the first is set."""

    POINTS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 1], [0, 1, 0], [0, 1, 1], [0, 0, 1]], dtype=float)

    @staticmethod
    def front(problem):
        return [(*goals, point.tolist()) for *goals, point in zip(*vars(problem.front).values(), strict=True)]

    def bits(self, tape=None, **limits):
        bowl = Cliff(Bowl(np.array([0.0, 1.0, 1.0])), 0.5, cap=-7.0)
        return make_problem(tape, bowl=bowl, box=Box(np.zeros(3), np.ones(3), kind="binary"), **limits)

    def test_it_has_the_best_for_each_number_of_springs_and_no_failed_candidate(self):
        problem = self.bits()
        goals = problem.objectives(self.POINTS)
        np.testing.assert_array_equal(goals[1:3], [[-7.0, 1], [-7.0, 3]])
        assert self.front(problem) == [(1.0, 0, [0, 0, 0]), (0.5, 1, [0, 1, 0]), (0.0, 2, [0, 1, 1])]

    def test_values_alone_do_not_join_it(self):
        problem = self.bits()
        problem.evaluate(self.POINTS)
        assert not problem.front

    def test_what_a_budget_left_of_a_batch_joins_it(self):
        problem = self.bits(evaluations=4)
        with pytest.raises(BudgetSpent):
            problem.objectives(self.POINTS)
        assert self.front(problem) == [(1.0, 0, [0, 0, 0]), (0.5, 1, [0, 1, 0])]

    @pytest.mark.parametrize("kept", [0, 3, 6])
    def test_replay_finds_the_same(self, kept):
        tape = Tape()
        whole, resumed = self.bits(tape), self.bits(Tape(tape.answers[:kept]))
        for problem in (whole, resumed):
            problem.objectives(self.POINTS)
        assert self.front(resumed) == self.front(whole)


class TestReplay:
    """A recorded answer is given again, without a solve, to the same question."""

    @staticmethod
    def live(problem):
        """Everything an optimizer can ask for."""
        answers = [problem.evaluate(points(2 * CHUNK + 3)), problem.budget_left]
        for point in points(4, seed=1):
            try:
                answers.append(problem.gradient(point))
            except NoEquilibrium as error:
                answers.append(str(error))
        answers.append(problem.linearize(CENTER)[0])
        return [*answers, problem.residuals(CENTER), problem.jacobian(CENTER), problem.budget_left]

    @pytest.mark.parametrize("limits", [{"evaluations": 1000}, {"seconds": 1000.0}])
    @pytest.mark.parametrize("kept", [0, 1, CHUNK, CHUNK + 10, 2 * CHUNK + 3, 2 * CHUNK + 5, 10_000])
    def test_every_kind_of_answer_is_the_same_to_the_bit(self, limits, kept):
        bowl, tape = Cliff(Bowl(CENTER), 6.0), Tape()
        whole = make_problem(tape, bowl=bowl, **limits)
        answers = self.live(whole)
        resumed = make_problem(Tape(tape.answers[:kept]), bowl=bowl, **limits)
        again = self.live(resumed)
        if kept > len(tape.answers) or "evaluations" in limits:
            for one, other in zip(answers, again, strict=True):
                np.testing.assert_equal(other, one)
        assert any(isinstance(answer, str) for answer in answers)
        assert course(resumed) == course(whole)
        assert resumed.meter.evaluations == whole.meter.evaluations

    def test_nothing_on_record_is_solved_again(self):
        tape = Tape()
        self.live(make_problem(tape))

        class Silent(Bowl):
            def evaluate(self, stiffness):
                raise AssertionError("solved")

            gradient = residuals = jacobian = evaluate

        resumed = make_problem(Tape(tape.answers), bowl=Silent(CENTER))
        self.live(resumed)
        with pytest.raises(AssertionError, match="solved"):
            resumed.evaluate(points(1))

    def test_products_with_a_recorded_jacobian_are_computed_again(self):
        tape, change = Tape(), np.array([1.0, -2.0, 0.5])
        for problem in (make_problem(tape), make_problem(Tape(tape.answers))):
            _, operator = problem.linearize(CENTER)
            np.testing.assert_array_equal(operator.matvec(change), change)
            np.testing.assert_array_equal(operator.rmatvec(change), change)
            assert (problem.meter.evaluations, problem.meter.solves) == (2, 2)

    def test_time_adds_up_and_replay_is_free(self):
        tape = Tape()
        make_problem(tape).evaluate(points(5))
        late = [answer._replace(seconds=70.0, processor_seconds=60.0, solving_seconds=50.0) for answer in tape.answers]
        resumed = make_problem(Tape(late), seconds=71.0)
        resumed.meter.clock.set(Times(500.0, 500.0, 500.0))
        resumed.evaluate(points(5))
        assert resumed.meter.clock.read() == pytest.approx((70.0, 60.0, 50.0), abs=0.5)
        resumed.evaluate(points(5))

    def test_an_answer_above_a_megabyte_leaves_a_digest_and_is_computed_again(self):
        size = 400  # a Jacobian of 400 x 400 numbers is 1.28 MB
        bowl, box = Bowl(np.ones(size)), Box(np.zeros(size), np.full(size, 10.0))
        tape = Tape()
        residuals, jacobian = make_problem(tape, bowl=bowl, box=box).jacobian(np.zeros(size))
        (answer,) = tape.answers
        assert answer.payload is None
        assert len(answer.checksum) == 16
        again = make_problem(Tape(tape.answers), bowl=bowl, box=box).jacobian(np.zeros(size))
        np.testing.assert_equal(again, (residuals, jacobian))
        elsewhere = dataclasses.replace(bowl, center=np.full(size, 1.0 + 1e-15))
        with pytest.raises(RecordBroken, match="a jacobian computed again differs from the recorded one"):
            make_problem(Tape(tape.answers), bowl=elsewhere, box=box).jacobian(np.zeros(size))

    def test_a_lost_equilibrium_is_on_record_with_its_message_and_its_cost(self):
        tape = Tape()
        with pytest.raises(NoEquilibrium):
            make_problem(tape, bowl=Cliff(Bowl(CENTER), 0.5)).gradient(CENTER)
        resumed = make_problem(Tape(tape.answers))
        with pytest.raises(NoEquilibrium, match=r"above 0\.5"):
            resumed.gradient(CENTER)
        assert (resumed.meter.evaluations, resumed.best_point) == (2, None)


def test_the_watch_is_called_before_each_solve_and_may_end_the_run_between_two_answers():
    class Stop(BaseException):
        pass

    def watch(meter):
        if meter.evaluations >= CHUNK:
            raise Stop

    tape = Tape()
    problem = make_problem(tape, watch=watch)
    with pytest.raises(Stop):
        problem.evaluate(points(2 * CHUNK))
    assert len(tape.answers) == problem.meter.evaluations == CHUNK
