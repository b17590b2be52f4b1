"""What an optimizer sees of a scene: a box, and answers to the points that it asks."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from numbers import Integral
from typing import TYPE_CHECKING, Any, Literal, Protocol, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from springopt.budget import Budget
from springopt.checks import Floats, Integers, floats, require_shape
from springopt.errors import OutsideBox, UserError
from springopt.forward.status import has_equilibrium
from springopt.front import Front
from springopt.ledger import Ledger
from springopt.meter import Meter
from springopt.race import Best, Racing, best_of
from springopt.recorder import Answer, Recorder
from springopt.run import LooseSelections
from springopt.selection import Selector

if TYPE_CHECKING:
    from scipy.sparse.linalg import LinearOperator


class Encoding(Protocol):
    """What a problem needs of an encoding; see `springopt.encoding`."""

    @property
    def kind(self) -> Literal["real", "binary"]: ...
    @property
    def size(self) -> int: ...
    @property
    def lower(self) -> Floats: ...
    @property
    def upper(self) -> Floats: ...
    @property
    def differentiable(self) -> bool: ...
    @property
    def parameter_count(self) -> int: ...
    def decode(self, points: ArrayLike) -> Floats: ...
    def encode(self, stiffness: ArrayLike) -> Floats: ...
    def pull_back(self, point: ArrayLike, gradient: ArrayLike) -> Floats: ...
    def push_forward(self, point: ArrayLike, change: ArrayLike) -> Floats: ...
    def sample(self, rng: np.random.Generator, count: int) -> Floats: ...


class Objective(Protocol):
    """What a problem needs of an objective, all of it in stiffness; see `springopt.objective`."""

    @property
    def tolerance(self) -> float: ...
    @property
    def cases(self) -> Sequence[Any]: ...
    def evaluate(self, stiffness: Floats) -> Any: ...
    def gradient(self, stiffness: Floats) -> tuple[float, Floats]: ...
    def residuals(self, stiffness: Floats) -> Floats: ...
    def value_of(self, residuals: Floats) -> float: ...
    def jacobian(self, stiffness: Floats) -> tuple[Floats, Floats]: ...
    def linearize(self, stiffness: Floats) -> tuple[Floats, LinearOperator]: ...


class Problem:
    """An objective over the box of an encoding, within a budget.

    When the budget is spent every question raises `BudgetSpent`, which unwinds any optimizer's loop. A batch that
    crosses the budget is answered as far as it fits (recorded and counted), and then raises.

    Args:
        objective: of a stiffness, shape (s,).
        encoding: from the points of the box to stiffness.
        budget: when to stop.
        recorder: keeps every answer, and gives recorded ones again without a solve.
        watch: called with the meter before each solve; what it raises ends the run between two answers.
        loosest_tolerance: that forward solves may have in `best_of`; by default the objective's own.

    Attributes:
        size: how many numbers a point has.
        kind: "real", or "binary" where every number is 0 or 1.
        lower, upper: corners of the box, shape (size,), read-only.
        objective, encoding: what an optimizer that uses the structure may read: lattice, load cases, reference.
        notes: by name, what the optimizer wants plotted, as (evaluations spent, number).
        front: the best for each number of springs among all points that `objectives` was asked for.
        meter: what was spent and the best, for whoever runs the optimizer.
    """

    def __init__(
        self,
        objective: Objective,
        encoding: Encoding,
        budget: Budget,
        recorder: Recorder | None = None,
        *,
        watch: Callable[[Meter], None] | None = None,
        loosest_tolerance: float | None = None,
    ) -> None:
        self.size = encoding.size
        self.kind = encoding.kind
        self.lower, self.upper = _read_only(encoding.lower), _read_only(encoding.upper)
        self.notes: dict[str, list[tuple[int, float]]] = {}
        self.front = Front()
        self.objective, self.encoding = objective, encoding
        self._start: Floats | None = None
        self._start_is_due = False
        training = sum(case.role == "train" for case in objective.cases)
        self._ledger = Ledger(budget, recorder, watch, tolerance=objective.tolerance, solves_each=training)
        self.meter = self._ledger.meter
        self._selector = _selector(objective, encoding, self._ledger, loosest_tolerance)

    @property
    def supplies(self) -> frozenset[str]:
        """What an optimizer may need and gets here: the kind of box, and which derivatives."""
        derivatives = {"gradient", "residuals", "jacobian"} if self.encoding.differentiable else set()
        structure = {"objective"} if hasattr(self.objective, "model") else set()
        return frozenset({self.kind} | derivatives | structure)

    @property
    def start(self) -> Floats | None:
        """A first guess, shape (size,), that the run was given and that was already asked; None without one."""
        return None if self._start is None else self._start.copy()

    def start_at(self, point: ArrayLike) -> None:
        """Gives the optimizer that follows a first guess: `start`, and the first point of its first `sample`."""
        self._start = self._in_box(point, (self.size,)).copy()
        self._start_is_due = True

    @property
    def best_point(self) -> Floats | None:
        """The point of the lowest value so far, shape (size,); None before the first answer."""
        return None if self.meter.best_point is None else self.meter.best_point.copy()

    @property
    def best_value(self) -> float:
        """The lowest value so far; inf before the first answer."""
        return self.meter.best_value

    @property
    def budget_total(self) -> float:
        """Evaluations that the whole run may cost; inf where they are not limited."""
        return math.inf if self.meter.budget.evaluations is None else self.meter.budget.evaluations

    @property
    def budget_left(self) -> float:
        """Evaluations left, a whole number: 0 when the budget is spent, inf where only a target is given.

        Under a time limit it is an estimate from the pace so far, and inf before the first answer.
        """
        return self._ledger.room()

    @property
    def loose_selections(self) -> LooseSelections | None:
        """What came of a loosest tolerance so far; None where none above the objective's own is allowed."""
        return None if self._selector is None else self._selector.fidelity.selections

    def sample(self, rng: np.random.Generator, count: int) -> Floats:
        """Points drawn uniformly from the box, shape (count, size); fair bits in a binary one.

        Where there is a start, it takes the place of the first point of the first call.
        """
        points = self.encoding.sample(rng, count)
        if self._start_is_due and count:
            points[0], self._start_is_due = self._start, False
        return points

    def note(self, **numbers: float) -> None:
        """Keeps numbers that the optimizer wants plotted over the evaluations: a mutation rate, a temperature.

        Raises UserError for a name that is no word.
        """
        for name, number in numbers.items():
            if not name.isidentifier():
                raise UserError(f"a note's name is a word as slope or step_size, not {name!r}; give another.")
            self.notes.setdefault(name, []).append((self.meter.evaluations, float(number)))

    def evaluate(self, points: ArrayLike) -> Floats:
        """Values of points, shape (m, size) -> (m,); never NaN, and graded where there is no equilibrium.

        Raises UserError for another shape, OutsideBox for a point outside the box.
        """
        return self._ledger.values(self._in_box(points, ("m", self.size)), self._solve_values)

    def best_of(self, points: ArrayLike, count: int, *, rivals: ArrayLike = ()) -> Best:
        """Which of points, shape (m, size), are among the best `count` of them and their rivals; 1 evaluation each.

        Rivals are values that are known already, shape (r,), as those of parents; among equals points come first, in
        their order. The answer is that of `evaluate`, but candidates that can't be among them are not solved to the
        end. Raises what `evaluate` raises.
        """
        asked = self._in_box(points, ("m", self.size))
        if isinstance(count, bool) or not isinstance(count, Integral) or count < 1:
            raise UserError(f"count must be a whole number from 1 on, not {count!r}.")
        others = require_shape("rivals", floats("rivals", rivals), ("r",))
        if np.isnan(others).any():
            raise UserError("rivals must be numbers, not nan; give values that the problem gave.")
        if self._selector is None:
            return best_of(self._ledger.values(asked, self._solve_values), count, others)
        return self._selector.best_of(asked, int(count), others, self._solve_values)

    def objectives(self, points: ArrayLike) -> Floats:
        """Several goals at once, shape (m, size) -> (m, 2): the value, and how many springs have a stiffness above 0.

        Candidates with an equilibrium join `front`.
        """
        asked = self._in_box(points, ("m", self.size))
        values = self._ledger.values(asked, self._solve_values, self._join_front)
        return np.column_stack([values, self._count_springs(asked)])

    def gradient(self, point: ArrayLike) -> tuple[float, Floats]:
        """Value and gradient, shape (size,), at a point; two evaluations. Raises NoEquilibrium."""
        self._require_derivatives()
        return self._ledger.numbers("gradient", self._in_box(point, (self.size,)), self._solve_gradient, cost=2)

    def residuals(self, point: ArrayLike) -> Floats:
        """Residuals, shape (r,), as in `Objective.residuals`; one evaluation. Raises NoEquilibrium.

        What counts as the point's value is the objective's own misfit, least squares or not.
        """
        self._require_derivatives()
        return self._ledger.numbers("residuals", self._in_box(point, (self.size,)), self._solve_residuals, cost=1)[1]

    def jacobian(self, point: ArrayLike) -> tuple[Floats, Floats]:
        """Residuals, shape (r,), and their Jacobian, shape (r, size); two evaluations. Raises NoEquilibrium."""
        self._require_derivatives()
        _, joined = self._ledger.numbers("jacobian", self._in_box(point, (self.size,)), self._solve_jacobian, cost=2)
        table = joined.reshape(-1, 1 + self.size)
        return table[:, 0].copy(), table[:, 1:].copy()

    def linearize(self, point: ArrayLike) -> tuple[Floats, LinearOperator]:
        """Residuals, shape (r,), and products with their Jacobian, (r, size), where it is too large to store.

        Two evaluations, however many products; each takes a linear solve for each load case. The operator's `matvec`
        multiplies with the Jacobian, its `rmatvec` with the transpose. Raises NoEquilibrium.
        """
        self._require_derivatives()
        asked, kept = self._in_box(point, (self.size,)).copy(), []

        def solve(at: Floats) -> tuple[float, Floats]:
            residuals, operator = self.objective.linearize(self.encoding.decode(at))
            kept.append(operator)
            return self.objective.value_of(residuals), residuals

        _, residuals = self._ledger.numbers("linearize", asked, solve, cost=2)

        def by_stiffness() -> LinearOperator:
            if not kept:  # residuals were on record, products never are
                solve(asked)
            return kept[0]

        return residuals, self._by_point(asked, len(residuals), by_stiffness)

    def _by_point(self, point: Floats, rows: int, by_stiffness: Callable[[], LinearOperator]) -> LinearOperator:
        from scipy.sparse.linalg import LinearOperator

        def along(change: Floats) -> Floats:
            with self.meter.clock.solving():
                return by_stiffness().matvec(self.encoding.push_forward(point, np.ravel(change)))

        def against(loads: Floats) -> Floats:
            with self.meter.clock.solving():
                return self.encoding.pull_back(point, by_stiffness().rmatvec(np.ravel(loads)))

        return LinearOperator((rows, self.size), matvec=along, rmatvec=against, dtype=float)

    def _solve_values(self, points: Floats) -> tuple[Floats, NDArray[np.int8]]:
        evaluation = self.objective.evaluate(self.encoding.decode(points))
        return evaluation.values, evaluation.codes

    def _join_front(self, points: Floats, answers: Sequence[Answer]) -> None:
        found = has_equilibrium(np.array([answer.status for answer in answers], dtype=np.int8))
        values = np.array([answer.value for answer in answers], dtype=float)
        self.front = self.front.joined(values[found], self._count_springs(points)[found], points[found])

    def _count_springs(self, points: Floats) -> Integers:
        rows = self.encoding.decode(points)
        return np.count_nonzero(rows[:, : rows.shape[1] - self.encoding.parameter_count], axis=1)

    def _solve_gradient(self, point: Floats) -> tuple[float, Floats]:
        value, gradient = self.objective.gradient(self.encoding.decode(point))
        return float(value), self.encoding.pull_back(point, gradient)

    def _solve_residuals(self, point: Floats) -> tuple[float, Floats]:
        residuals = self.objective.residuals(self.encoding.decode(point))
        return self.objective.value_of(residuals), residuals

    def _solve_jacobian(self, point: Floats) -> tuple[float, Floats]:
        residuals, jacobian = self.objective.jacobian(self.encoding.decode(point))
        joined = np.column_stack([residuals, self.encoding.pull_back(point, jacobian)])
        return self.objective.value_of(residuals), joined.ravel()

    def _require_derivatives(self) -> None:
        if not self.encoding.differentiable:
            raise UserError(
                f"derivatives need an encoding that has them, and this scene's {self.kind} one has none; "
                "give it a real encoding, or choose an optimizer that needs values alone."
            )

    def _in_box(self, points: ArrayLike, shape: tuple[int | str, ...]) -> Floats:
        if isinstance(points, np.ndarray) and points.dtype == bool:
            points = points.astype(float)
        numbers = floats("an optimizer's points", points)
        array = np.ascontiguousarray(require_shape("an optimizer's points", numbers, shape))
        inside = (array >= self.lower) & (array <= self.upper)
        if not inside.all():
            *_, coordinate = entry = tuple(np.argwhere(~inside)[0])
            raise OutsideBox(
                f"coordinate {coordinate} of an optimizer's point is {array[entry]:.17g}, outside its interval "
                f"[{self.lower[coordinate]:g}, {self.upper[coordinate]:g}]; keep to problem.lower and problem.upper."
            )
        if self.kind == "binary" and (broken := (array != 0) & (array != 1)).any():
            raise OutsideBox(
                f"an optimizer's point holds {array[broken][0]:.17g}, and a binary encoding takes 0 and 1 alone; "
                'round it, or let the optimizer need "real".'
            )
        return array


def _selector(
    objective: Objective, encoding: Encoding, ledger: Ledger, loosest_tolerance: float | None
) -> Selector | None:
    """What races candidates, where the objective can be solved in stages."""
    # Of its own class: what wraps an objective and passes its attributes on would be raced past.
    if not hasattr(type(objective), "stages"):
        return None
    return Selector(cast("Racing", objective), encoding.decode, ledger, loosest_tolerance)


def _read_only(bound: Floats) -> Floats:
    copy = np.array(bound, dtype=float)
    copy.flags.writeable = False
    return copy
