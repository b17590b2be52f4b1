"""Local searches from one start after the other, until the best value has been met again and again."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from springopt.checks import Floats
from springopt.errors import NoEquilibrium, UserError
from springopt.problem import Problem

#: Values within this share of the best one are the same minimum.
SAME = 1e-4


def search_from_starts(
    problem: Problem,
    rng: np.random.Generator,
    search: Callable[[Floats], float],
    *,
    starts: int | None,
    agree: int,
) -> None:
    """Searches from the problem's start or a random point, then from further random ones.

    `search` gives the value in which it ended, zero where nothing is left to find; NoEquilibrium says that there is
    none at the start, and the next one is drawn. It ends at zero, after `starts` searches, or when `agree` of them
    have ended at the best value.
    """
    ended: list[float] = []
    while starts is None or len(ended) < starts:
        try:
            ended.append(search(problem.sample(rng, 1)[0]))
        except NoEquilibrium:
            continue
        at_best = sum(value <= (1 + SAME) * min(ended) for value in ended)
        problem.note(searches=len(ended), searches_at_best=at_best)
        if min(ended) == 0 or 0 < agree <= at_best:
            return


def require_counts(name: str, starts: int | None, agree: int) -> None:
    """Refuses counts of searches that make no sense."""
    if starts is not None and starts < 1:
        raise UserError(f"option starts of {name} is at least 1, or none, not {starts}; give another number.")
    if agree < 0:
        raise UserError(f"option agree of {name} is 0 or more, not {agree}; 0 lets it go on for ever.")
