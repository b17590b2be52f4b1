"""How a problem finds the best of a batch: raced where that pays, and loosely where it may."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from springopt.checks import Floats, Integers
from springopt.fidelity import Fidelity, Plan
from springopt.ledger import Ledger, SolveValues
from springopt.race import Best, Known, Raced, Racing, best_of, pays, race, solve_all
from springopt.recorder import Outcome

# What takes how long is told in eights of equilibria, since so many are found at a time and a few take as long. Beside
# them, on scenes as small as the paper's, the equilibria of a stage take one more, and the stage of a race another bit.
CALL, TOLL = 1.0, 0.7
BLOCK = 200  # eights over which it is judged whether races pay
WORTH = 0.1  # share of them that races must save
FIRST_PAUSE, LONGEST_PAUSE = 2, 16  # blocks; what pays may change on the way


@dataclass
class Patience:
    """Whether races pay; where they don't they pause, each time twice as long. It changes with each batch."""

    pause: int = 0  #: blocks without a race, after the last block that did not pay
    left: float = 0.0  #: eights still to come in this pause
    taken: float = 0.0  #: eights that races took in this block
    whole: float = 0.0  #: eights that solving everything would have taken

    def is_ready(self, whole: float) -> bool:
        """Whether the next batch, of so many eights, is raced."""
        if self.left <= 0:
            return True
        self.left -= whole
        return False

    def learn(self, taken: float, whole: float) -> None:
        """Takes notice of a race."""
        self.taken += taken
        self.whole += whole
        if self.whole >= BLOCK:
            is_worth_it = self.taken <= (1.0 - WORTH) * self.whole
            self.pause = 0 if is_worth_it else min(max(2 * self.pause, FIRST_PAUSE), LONGEST_PAUSE)
            self.left, self.taken, self.whole = float(self.pause * BLOCK), 0.0, 0.0


class Selector:
    """Answers `Problem.best_of` in one run; what it learns on the way decides how, and is a function of the answers.

    Args:
        objective: whose load cases are solved in stages.
        decode: from points, shape (m, size), to candidates, shape (m, s).
        ledger: of the run.
        loosest_tolerance: that the forward solve may have here; None is the objective's own.
    """

    def __init__(
        self,
        objective: Racing,
        decode: Callable[[Floats], Floats],
        ledger: Ledger,
        loosest_tolerance: float | None = None,
    ) -> None:
        self._objective, self._decode, self._ledger = objective, decode, ledger
        self._sizes = [len(stage.cases) for stage in objective.stages]
        self._patience = Patience()
        self.fidelity = Fidelity(objective.tolerance, loosest_tolerance or objective.tolerance)

    def best_of(self, points: Floats, count: int, rivals: Floats, solve_values: SolveValues) -> Best:
        """See `Problem.best_of`; `solve_values` is what `Problem.evaluate` does."""
        plan = self.fidelity.plan()
        is_raced = self._is_raced(len(points), Known(count, rivals))
        most = 2 if plan.is_loose else 1  # solves of a load case, which the budget must have left
        fits = self._ledger.meter.counted_room() >= most * len(points)
        if not (fits and (is_raced or plan.is_loose)):
            values = self._ledger.values(points, solve_values)
            self.fidelity.see(values)
            return best_of(values, count, rivals)
        outcomes = self._ledger.raced(points, functools.partial(self._run, plan, is_raced, count, rivals))
        values = np.array([outcome.value for outcome in outcomes])
        loose_values = np.array([outcome.loose_value for outcome in outcomes])
        if is_raced and not plan.is_compared:
            again = np.where(np.isnan(loose_values), 0, sum(self._sizes))  # what followed the race
            self._patience.learn(*self._lengths(np.array([outcome.solves for outcome in outcomes]) - again))
        if plan.is_loose:
            self.fidelity.learn(plan, values, loose_values, count, rivals)
        self.fidelity.see(values)
        return best_of(values, count, rivals)

    def _lengths(self, solves: Integers) -> tuple[float, float]:
        """What a race took in which candidates had so many solves, (m,), and what they would have taken without one."""
        sizes = self._sizes
        racers = [int((solves > begun).sum()) for begun in np.cumsum([0, *sizes[:-1]])]
        taken = sum(_eights(count * size) + TOLL for count, size in zip(racers, sizes, strict=True) if count)
        return taken, self._length(len(solves))

    def _length(self, candidate_count: int) -> float:
        """What so many candidates take without a race."""
        return sum(_eights(candidate_count * size) for size in self._sizes)

    def _is_raced(self, candidate_count: int, known: Known) -> bool:
        if len(self._sizes) == 1 or not pays(candidate_count, known):
            return False
        return self._patience.is_ready(self._length(candidate_count))

    def _run(
        self,
        plan: Plan,
        is_raced: bool,
        count: int,
        rivals: Floats,
        points: Floats,
        before: Sequence[Outcome],
        best: float,
    ) -> list[Outcome]:
        """The outcomes of a chunk of points; see `ledger.SolveRace`."""
        candidates = np.ascontiguousarray(self._decode(points))  # or parts would have the kernels compiled once more
        joined = np.concatenate([rivals, [outcome.value for outcome in before]])
        limit = self._ledger.meter.budget.target
        target = -math.inf if limit is None else limit
        kept = target if plan.is_compared else target + plan.error  # which is inf before any was measured

        def find(tolerance: float) -> Raced:
            if not is_raced:
                return solve_all(self._objective, candidates, tolerance)
            return race(self._objective, candidates, Known(count, joined, kept), best=best, tolerance=tolerance)

        own = self._objective.tolerance
        if not plan.is_loose:
            return _outcomes(find(own), own)
        loose = find(plan.tolerance)
        outcomes = _outcomes(loose, plan.tolerance)
        if plan.is_compared:
            again, exact = np.arange(len(points)), find(own)
        else:  # what may become the best, or reach the target, rests on the scene's own
            error = plan.error
            again = np.flatnonzero((loose.values < best + error) | (loose.values <= target + error))
            exact = solve_all(self._objective, candidates[again], own)
        for place, outcome in zip(again.tolist(), _outcomes(exact, own), strict=True):
            solves, loose_value = outcome.solves + outcomes[place].solves, outcomes[place].value
            outcomes[place] = outcome._replace(solves=solves, loose_value=loose_value)
        return outcomes


def _eights(count: int) -> float:
    return CALL - (-count // 8)  # lanes of `springopt.effects.lanes`, which would have numba imported


def _outcomes(raced: Raced, tolerance: float) -> list[Outcome]:
    columns = zip(raced.values.tolist(), raced.codes.tolist(), raced.solves.tolist(), strict=True)
    return [Outcome(value, code, solves, tolerance) for value, code, solves in columns]
