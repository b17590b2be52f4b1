"""How a problem finds the best of a batch: raced where that pays, and loosely where it may."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from springopt.checks import Floats
from springopt.fidelity import Fidelity, Plan
from springopt.ledger import Ledger, SolveValues
from springopt.race import Best, Known, Raced, Racing, best_of, pays, race, solve_all
from springopt.recorder import Outcome

BLOCK = 32  # candidates over which it is judged whether races pay
WORTH = 0.1  # share of the solves that races must save to pay for their stages
LONGEST_PAUSE = 4096  # candidates


@dataclass
class Patience:
    """Whether races pay; where they don't they pause, each time twice as long. It changes with each race."""

    pause: int = 0  #: candidates that were not raced after the last block that did not pay
    left: int = 0  #: of these still to come
    raced: int = 0  #: candidates of this block
    saved: float = 0.0  #: of their solves, in candidates

    def is_ready(self, candidate_count: int) -> bool:
        """Whether the next batch is raced."""
        if self.left <= 0:
            return True
        self.left -= candidate_count
        return False

    def learn(self, candidate_count: int, saved: float) -> None:
        """Takes notice of a race that saved what so many candidates would have cost."""
        self.raced += candidate_count
        self.saved += saved
        if self.raced >= BLOCK:
            pays = self.saved >= WORTH * self.raced
            self.pause = 0 if pays else min(max(2 * self.pause, BLOCK), LONGEST_PAUSE)
            self.left, self.raced, self.saved = self.pause, 0, 0.0


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
        self._solves_each = sum(len(stage.cases) for stage in objective.stages)
        self._patience = Patience()
        self.fidelity = Fidelity(objective.tolerance, loosest_tolerance or objective.tolerance)

    def best_of(self, points: Floats, count: int, rivals: Floats, solve_values: SolveValues) -> Best:
        """See `Problem.best_of`; `solve_values` is what `Problem.evaluate` does."""
        plan = self.fidelity.plan()
        is_raced = self._is_raced(len(points), Known(count, rivals))
        fits = self._ledger.meter.counted_room() >= len(points)
        if fits and (is_raced or plan.is_loose):
            outcomes = self._ledger.raced(points, functools.partial(self._run, plan, is_raced, count, rivals))
        else:
            values = self._ledger.values(points, solve_values)
            outcomes = [Outcome(value, 0, self._solves_each, plan.tolerance) for value in values.tolist()]
        if is_raced:
            solves = sum(outcome.solves for outcome in outcomes)
            self._patience.learn(len(points), len(points) - solves / self._solves_each)
        self.fidelity.learn(plan, outcomes, count, rivals)
        return best_of(np.array([outcome.value for outcome in outcomes]), count, rivals)

    def _is_raced(self, candidate_count: int, known: Known) -> bool:
        return (
            len(self._objective.stages) > 1
            and pays(candidate_count, known)
            and self._patience.is_ready(candidate_count)
        )

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
        candidates = self._decode(points)
        joined = np.concatenate([rivals, [outcome.value for outcome in before]])
        target = self._ledger.meter.budget.target
        # What becomes the best, or reaches the target, must not be missed.
        sought = best if target is None else max(best, target)
        kept = -math.inf if target is None else target

        def find(tolerance: float, margin: float) -> Raced:
            if not is_raced:
                return solve_all(self._objective, candidates, tolerance)
            known = Known(count, joined, kept + margin)
            return race(self._objective, candidates, known, best=best + margin, tolerance=tolerance)

        own = self._objective.tolerance
        if not plan.is_loose:
            return _outcomes(find(own, 0.0), own)
        loose = find(plan.tolerance, plan.error)
        outcomes = _outcomes(loose, plan.tolerance)
        if plan.is_compared:
            again, exact = np.arange(len(points)), find(own, 0.0)
        else:
            again = np.flatnonzero(loose.values <= sought + plan.error)
            exact = solve_all(self._objective, candidates[again], own)
        for place, outcome in zip(again.tolist(), _outcomes(exact, own), strict=True):
            solves, loose_value = outcome.solves + outcomes[place].solves, outcomes[place].value
            outcomes[place] = outcome._replace(solves=solves, loose_value=loose_value)
        return outcomes


def _outcomes(raced: Raced, tolerance: float) -> list[Outcome]:
    columns = zip(raced.values.tolist(), raced.codes.tolist(), raced.solves.tolist(), strict=True)
    return [Outcome(value, code, solves, tolerance) for value, code, solves in columns]
