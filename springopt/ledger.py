"""The ledger of a run: every answer is taken from the record or solved, then recorded and counted."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from springopt.budget import Budget
from springopt.checks import Floats
from springopt.errors import BudgetSpent, NoEquilibrium, RecordBroken, RunFileError, SpringoptError
from springopt.meter import Meter, Times
from springopt.recorder import (
    LARGEST_PAYLOAD,
    NO_EQUILIBRIUM,
    NO_QUESTION,
    RACED,
    Answer,
    NullRecorder,
    Outcome,
    Recorder,
    digest,
)

SolveValues = Callable[[Floats], tuple[Floats, NDArray[np.int8]]]  # points -> values and statuses, (m,) each
#: Points of a chunk, the outcomes of those before it, the best value so far -> the outcomes, one each.
SolveRace = Callable[[Floats, Sequence[Outcome], float], list[Outcome]]
SolveNumbers = Callable[[Floats], tuple[float, Floats]]  # point -> value and derivatives
Keep = Callable[[Floats, Sequence[Answer]], None]  # points, shape (m, size), and their answers

CHUNK = 64  # candidates solved between two looks at the clock, the target and Ctrl-C


class Ledger:
    """Answers questions within the budget; raises BudgetSpent when it is spent.

    Whatever has a place in the record is answered from there, without a solve and with the clock set to the time when
    it was first given: a resumed run lives through the same answers as the one that was cut short.

    Args:
        budget: when to stop.
        recorder: keeps every answer; by default nothing is kept.
        watch: called with the meter before each solve; what it raises ends the run between two answers.
        tolerance: of the forward solve, noted beside each answer.
        solves_each: forward solves of one candidate.
    """

    def __init__(
        self,
        budget: Budget,
        recorder: Recorder | None = None,
        watch: Callable[[Meter], None] | None = None,
        *,
        tolerance: float,
        solves_each: int,
    ) -> None:
        self.meter = Meter(budget, solves_each=solves_each)
        self._recorder = recorder or NullRecorder()
        self._watch = watch or (lambda meter: None)
        self._tolerance = tolerance

    def room(self) -> float:
        """Evaluations left; under a time limit the reading depends on the clock, and is recorded."""
        if self.meter.budget.seconds is None:
            return self.meter.counted_room()
        answers = self._recorder.recorded("budget_left", [NO_QUESTION])
        if answers:
            self._rewind(answers)
        else:
            answers = [self._answer("budget_left", NO_QUESTION, self.meter.room())]
            self._recorder.record(answers)
        room = float(answers[0].value or 0)
        return room if math.isinf(room) else int(room)

    def values(self, points: Floats, solve: SolveValues, keep: Keep | None = None) -> Floats:
        """Values of points, shape (m, size) -> (m,); of a batch that crosses the budget the first part is answered.

        Whatever is answered goes through `keep`, also where the batch ends in BudgetSpent.
        """
        values: list[float] = []
        while len(values) < len(points):
            chunk = points[len(values) :][:CHUNK]
            answers = self._next_answers(chunk, solve)
            values += [float(answer.value) for answer in answers if answer.value is not None]
            if keep:
                keep(chunk[: len(answers)], answers)
        return np.array(values, dtype=float)

    def raced(self, points: Floats, race: SolveRace) -> list[Outcome]:
        """Outcomes of points, shape (m, size), whose race is run chunk by chunk; all of them fit the counted budget."""
        outcomes: list[Outcome] = []
        for begin in range(0, len(points), CHUNK):
            chunk = points[begin : begin + CHUNK]
            answers = self._raced_chunk(chunk, functools.partial(race, chunk, outcomes, self.meter.best_value))
            outcomes += [answer.outcome() for answer in answers]
        return outcomes

    def numbers(self, kind: str, point: Floats, solve: SolveNumbers, *, cost: int) -> tuple[float, Floats]:
        """Value and derivatives, flat, at a point, shape (size,). Raises NoEquilibrium, also from the record."""
        self.meter.require_room(cost)
        question = digest(point)
        recorded = self._recorder.recorded(kind, [question])
        if recorded:
            answer, numbers = recorded[0], _recall(recorded[0], point, solve)
            self._rewind(recorded)
        else:
            self._before_solve()
            answer, numbers = self._solve_numbers(kind, question, point, solve)
            self._recorder.record([answer])
        self.meter.count(point[None], [answer], cost=cost)
        if answer.value is None:
            raise NoEquilibrium((answer.payload or b"").decode())
        return answer.value, numbers

    def _next_answers(self, points: Floats, solve: SolveValues) -> list[Answer]:
        """Answers to the first few of these points, at least to one; raises BudgetSpent if none fits."""
        self.meter.require_room(cost=1)
        points = points[: int(min(self.meter.counted_room(), len(points)))]
        questions = [digest(point) for point in points]
        answers = self._recorder.recorded("value", questions)
        if answers:
            self._rewind(answers)
        else:
            self._before_solve()
            answers = self._solve_values(points, questions, solve)
            self._recorder.record(answers)
        self.meter.count(points[: len(answers)], answers)
        return answers

    def _raced_chunk(self, points: Floats, race: Callable[[], list[Outcome]]) -> list[Answer]:
        """Answers to all of these points; raises BudgetSpent where one before the last reaches the target."""
        self.meter.require_room(cost=1)
        questions = [digest(point) for point in points]
        answers = self._recorder.recorded(RACED, questions)
        if answers:
            self._rewind(answers)
            self.meter.count(points[: len(answers)], answers)
        # A race is run as a whole: a record that ends within it is gone on with by running it once more.
        if len(answers) < len(points):
            self.meter.require_room(cost=1)
            self._before_solve()
            new = self._solve_race(questions, race)[len(answers) :]
            self._recorder.record(new)
            self.meter.count(points[len(answers) :][: len(new)], new)
            answers += new
        if len(answers) < len(points):
            raise BudgetSpent
        return answers

    def _solve_race(self, questions: list[bytes], race: Callable[[], list[Outcome]]) -> list[Answer]:
        with self.meter.clock.solving():
            outcomes = race()
        answered = self._until_target([outcome.value for outcome in outcomes])
        _finite("value", np.array([value for value in answered if value != math.inf]))
        clock = self.meter.clock.read()
        return [Answer.raced(*pair, clock) for pair in zip(questions, outcomes[: len(answered)], strict=False)]

    def _solve_values(self, points: Floats, questions: list[bytes], solve: SolveValues) -> list[Answer]:
        with self.meter.clock.solving():
            values, statuses = solve(points)
        answered = self._until_target(_finite("value", values).tolist())
        clock = self.meter.clock.read()
        return [
            Answer("value", question, self._tolerance, status, value, *clock)
            for question, status, value in zip(questions, statuses.tolist(), answered, strict=False)
        ]

    def _until_target(self, values: list[float]) -> list[float]:
        """The values up to the first that reaches the target: the run ends there, whatever the batch."""
        target = self.meter.budget.target
        if target is None or min(values) > target:
            return values
        return values[: 1 + next(i for i, value in enumerate(values) if value <= target)]

    def _solve_numbers(self, kind: str, question: bytes, point: Floats, solve: SolveNumbers) -> tuple[Answer, Floats]:
        try:
            with self.meter.clock.solving():
                value, solved = solve(point)
        except NoEquilibrium as error:
            return self._answer(kind, question, None, NO_EQUILIBRIUM, payload=str(error).encode()), np.empty(0)
        numbers = np.array(_finite(kind, solved), order="C")
        if numbers.nbytes > LARGEST_PAYLOAD:
            return self._answer(kind, question, value, checksum=digest(numbers)), numbers
        return self._answer(kind, question, value, payload=numbers.tobytes()), numbers

    def _answer(
        self,
        kind: str,
        question: bytes,
        value: float | None,
        status: int = 0,
        *,
        payload: bytes | None = None,
        checksum: bytes | None = None,
    ) -> Answer:
        clock = self.meter.clock.read()
        return Answer(kind, question, self._tolerance, status, value, *clock, payload, checksum)

    def _before_solve(self) -> None:
        self._watch(self.meter)
        self.meter.require_time()

    def _rewind(self, answers: Sequence[Answer]) -> None:
        last = answers[-1]
        self.meter.clock.set(Times(last.seconds, last.processor_seconds, last.solving_seconds))


def _recall(answer: Answer, point: Floats, solve: SolveNumbers) -> Floats:
    """The numbers of a recorded answer; those that were too large to keep are computed again."""
    if answer.value is None:
        return np.empty(0)
    if answer.payload is not None:
        return np.frombuffer(answer.payload).copy()
    numbers = np.array(solve(point)[1], order="C")
    if digest(numbers) != answer.checksum:
        raise RecordBroken(
            RunFileError(
                f"a {answer.kind} computed again differs from the recorded one, and exactness is promised for the same "
                "build and processor type only; start a new run."
            )
        )
    return numbers


def _finite(name: str, numbers: Floats) -> Floats:
    """Passes an objective's numbers on; a NaN never reaches an optimizer."""
    if not np.isfinite(numbers).all():
        raise SpringoptError(f"the objective gave a {name} that is not finite; it must give a number for every point.")
    return numbers
