"""Force balance: with all positions and forces known, the stiffness is a linear least-squares problem.

At the reference's positions x every free degree of freedom is in balance, A(x) k = f, where spring s adds to A what it
pulls with per stiffness, and f are the loads. No equilibrium is sought, but for the value of the one answer.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Literal, NamedTuple, cast

import numpy as np
from scipy.linalg import cho_factor, cho_solve, qr, solve_triangular

from springopt.checks import Booleans, Floats, Integers
from springopt.errors import NotServed, UserError
from springopt.optimizer import Optimizer
from springopt.problem import Problem

if TYPE_CHECKING:  # kernels, which are not to be imported where optimizers are only listed
    from springopt.objective import Objective

#: How strongly an unknown that no load case tells is drawn to the common number, beside the others' weight.
DRAW = 1e-9
#: In the flexibility that weighs forces no spring is softer than this share of the mean.
SOFTEST = 1e-2
#: What is added to that flexibility's stiffness, as a share of its mean, where a lattice is a mechanism at rest.
SHIFT = 1e-9
#: What is added to normal equations, as a share of their largest entry for each unknown: more than rounding takes off.
RIDGE = 1e-13
ROUNDS = 50
#: Where no larger share of the loads is left over, another measure would not change the answer.
EXACT = 1e-9
LARGEST_BYTES = 4e9


@dataclass(frozen=True)
class Balance(Optimizer):
    """Bounded least squares on the balance of forces at the reference's positions; one evaluation."""

    name: ClassVar[str] = "balance"
    needs: ClassVar[tuple[str, ...]] = ("objective",)
    #: What is made small: the displacements that the forces left over would cause, or these forces themselves.
    measure: Literal["displacements", "forces"] = "displacements"
    passes: int = 2  #: displacements are those of a lattice of equal springs first, then of each pass's answer

    def __post_init__(self) -> None:
        if self.passes < 1:
            raise UserError(f"option passes of balance is at least 1, not {self.passes}; give more.")

    def minimize(self, problem: Problem, rng: np.random.Generator) -> None:
        objective, encoding, lower = cast("Objective", problem.objective), problem.encoding, problem.lower
        _require_springs_alone(objective)
        cases = _cases(objective, problem.size)
        origin = encoding.decode(lower)
        slopes = encoding.pull_back(lower, np.eye(len(origin)))
        balances = [_balance(case, origin, slopes) for case in cases]
        numbers = self._numbers(cases, balances, lambda z: origin + slopes @ z, problem.upper - lower)
        problem.note(imbalance=_imbalance(balances, numbers))
        point = np.round(numbers) if problem.kind == "binary" else lower + numbers
        problem.evaluate([np.clip(point, lower, problem.upper)])

    def _numbers(
        self, cases: list[Case], balances: list[Floats], stiffness_of: Callable[[Floats], Floats], width: Floats
    ) -> Floats:
        """The point less the lower corner of the box, shape (size,): by the forces first, which suffice if all fit."""
        numbers = _solved(cases, balances, width)
        stiffness: Floats = np.ones(len(cases[0].springs))
        for _ in range(self.passes if self.measure == "displacements" else 0):
            if _imbalance(balances, numbers) <= EXACT:
                break
            pairs = zip(cases, balances, strict=True)
            numbers = _solved(
                cases, [cho_solve(cho_factor(_tangent(case, stiffness)), rows) for case, rows in pairs], width
            )
            stiffness = stiffness_of(numbers)
        return numbers


class Case(NamedTuple):
    """One load case at the reference's positions."""

    springs: Integers  #: shape (s, 2)
    vectors: Floats  #: of the springs, from first to second node [length], shape (s, d)
    pulls: Floats  #: what each spring pulls its first node with, over its stiffness [length], shape (s, d)
    forces: Floats  #: [force], shape (n, d)
    free: Booleans  #: shape (n, d)
    weight: float


def bounded_least_squares(matrix: Floats, wanted: Floats, upper: Floats) -> Floats:
    """The z (size,), 0 <= z <= upper, with the least |matrix z - wanted|.

    What the rows do not tell, or next to nothing, comes out as close to the common number as it may be: the one that
    does best if all have it.
    """
    sums = matrix.sum(axis=1)
    common = np.clip(sums @ wanted / max(sums @ sums, np.finfo(float).tiny), 0.0, upper)
    size = len(upper)
    draw = DRAW * (np.abs(matrix).max(initial=0.0) or 1.0)
    rows = np.vstack([np.column_stack([matrix, wanted - matrix @ common]), draw * np.eye(size, size + 1)])
    triangle = qr(rows, mode="r", overwrite_a=True, check_finite=False)[0][:size]
    away = _away(triangle[:, :size], triangle[:, size], -common, upper - common)
    return np.clip(common + away, 0.0, upper)


def _away(triangle: Floats, wanted: Floats, lower: Floats, upper: Floats) -> Floats:
    """The y in [lower, upper] with the least |triangle y - wanted|."""
    place = _places(triangle.T @ triangle, triangle.T @ wanted, lower, upper)
    if place is None:
        from scipy.optimize import lsq_linear  # slow to import, and seldom needed

        return lsq_linear(triangle, wanted, (lower, upper), method="bvls", max_iter=10 * len(lower)).x
    free, y = place == 0, np.select([place < 0, place > 0], [lower, upper])
    q, r = qr(triangle[:, free], mode="economic", check_finite=False)
    y[free] = solve_triangular(r, q.T @ (wanted - triangle @ y), check_finite=False)
    return y


def _places(gram: Floats, pull: Floats, lower: Floats, upper: Floats) -> Integers | None:
    """Which unknowns of bounded normal equations lie at a bound: -1 at the lower, 1 at the upper, 0 between.

    By block pivoting (Portugal, Judice and Vicente 1994): all that are in the wrong place change it at once. That
    nearly always ends within ten rounds, and is given up after some more.
    """
    ridge = RIDGE * len(pull)
    gram[np.diag_indices_from(gram)] += ridge * gram.diagonal().max()
    margin = ridge * np.abs(pull).max()
    place = np.zeros(len(lower), dtype=np.int64)
    for _ in range(ROUNDS):
        y = np.select([place < 0, place > 0], [lower, upper])
        free = place == 0
        y[free] = cho_solve(cho_factor(gram[np.ix_(free, free)]), pull[free] - gram[free] @ y)
        slope = gram @ y - pull
        leaves = ~free & (np.sign(slope) == place) & (np.abs(slope) > margin)
        should = np.select([free & (y < lower), free & (y > upper), leaves], [-1, 1, 0], place)
        if (should == place).all():
            return place
        place = should
    return None


def _solved(cases: list[Case], equations: list[Floats], width: Floats) -> Floats:
    """Least squares of the equations of all load cases, (rows, size + 1) each, by their weights."""
    rows = np.concatenate([np.sqrt(case.weight) * own for case, own in zip(cases, equations, strict=True)])
    return bounded_least_squares(rows[:, :-1], rows[:, -1], width)


def _cases(objective: Objective, size: int) -> list[Case]:
    """The training load cases; refuses more than memory holds, since the least squares are dense, and no forces."""
    model, lattice = objective.model, objective.model.lattice
    numbers = [number for number, case in enumerate(objective.cases) if case.role == "train"]
    needed = 3.0 * 8 * len(numbers) * lattice.nodes.size * max(size, lattice.spring_count)
    if needed > LARGEST_BYTES:
        raise NotServed(
            f"balance would need some {needed / 1e9:.0f} GB of memory for {lattice.spring_count} springs in "
            f"{len(numbers)} load cases, and stops at {LARGEST_BYTES / 1e9:.0f}; use l-bfgs-b.",
            word="memory",
        )
    positions = objective.reference_positions[numbers]
    pulls = model.forces_per_stiffness(positions)
    first, second = lattice.springs.T
    at = np.broadcast_to(lattice.nodes, positions.shape) if model.kinematics == "linear" else positions
    weights = np.ones(len(objective.cases)) if objective.weights is None else objective.weights
    cases = [
        Case(lattice.springs, x[second] - x[first], pull, case.forces + model.constant_forces(), case.free, weight)
        for x, pull, case, weight in zip(
            at, pulls, (objective.cases[number] for number in numbers), weights[numbers], strict=True
        )
    ]
    if not any(case.forces[case.free].any() for case in cases):
        raise NotServed(
            "balance needs forces, and under prescribed displacements alone every multiple of a stiffness does the "
            "same; use gauss-newton.",
            word="forces",
        )
    return cases


def _balance(case: Case, origin: Floats, slopes: Floats) -> Floats:
    """A z = f at the free degrees of freedom, with f as the last column, shape (r, size + 1).

    z is the point less the lower corner of the box: the stiffness is origin (s,) + slopes (s, size) z.
    """
    springs, numbers = case.springs, np.arange(len(case.springs))
    matrix = np.zeros((*case.forces.shape, len(springs)))
    matrix[springs[:, 0], :, numbers] -= case.pulls
    matrix[springs[:, 1], :, numbers] += case.pulls
    rows = matrix[case.free]
    return np.column_stack([rows @ slopes, case.forces[case.free] - rows @ origin])


def _tangent(case: Case, stiffness: Floats) -> Floats:
    """The stiffness at the reference's positions, a spring's pressure left out: positive definite, shape (r, r)."""
    squares = np.square(case.vectors).sum(axis=1)
    pull = np.maximum(_over((case.pulls * case.vectors).sum(axis=1), squares), 0.0)
    axial = _over(1.0 - pull, squares)
    own = axial[:, None, None] * case.vectors[:, :, None] * case.vectors[:, None]
    own += pull[:, None, None] * np.eye(case.vectors.shape[1])
    blocks = np.maximum(stiffness, SOFTEST * stiffness.mean())[:, None, None] * own
    (n, d), (i, j) = case.forces.shape, case.springs.T
    whole = np.zeros((n, n, d, d))
    for a, b, sign in ((i, i, 1), (j, j, 1), (i, j, -1), (j, i, -1)):
        np.add.at(whole, (a, b), sign * blocks)
    free = case.free.ravel()
    tangent = whole.swapaxes(1, 2).reshape(n * d, n * d)[np.ix_(free, free)]
    return tangent + SHIFT * np.trace(tangent) / len(tangent) * np.eye(len(tangent))


def _imbalance(balances: list[Floats], numbers: Floats) -> float:
    """The norm of the forces left over, as a share of the loads'."""
    rows = np.concatenate(balances)
    loads = np.linalg.norm(rows[:, -1])
    return float(np.linalg.norm(rows[:, :-1] @ numbers - rows[:, -1]) / loads) if loads else 0.0


def _require_springs_alone(objective: Objective) -> None:
    """Refuses motions, fitted parameters, and effects whose forces depend on more than the stiffness of springs."""
    terms = objective.model.terms
    if any(case.times is not None for case in objective.cases):
        raise NotServed(
            "balance knows forces at rest, and these load cases have times; leave the times out, or use gauss-newton.",
            word="motion",
        )
    for term, _ in terms.potentials:
        raise NotServed(
            f"balance knows springs and constant forces, and {term.name} adds forces of its own; "
            "leave it out, or use gauss-newton.",
            word="effects",
        )
    if terms.fitted:
        raise NotServed(
            f"balance finds the stiffness alone, and this scene fits {', '.join(terms.fitted)} too; leave "
            "encoding.parameters out, or use gauss-newton.",
            word="parameters",
        )


def _over(numbers: Floats, divisors: Floats) -> Floats:
    """Numbers over divisors, 0 where these are: springs without a length."""
    return np.divide(numbers, divisors, out=np.zeros_like(numbers), where=divisors > 0)
