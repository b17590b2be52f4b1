"""What a run may cost, and the value at which it may stop early."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from numbers import Integral, Real
from typing import Any

from springopt.errors import UserError

_KINDS: dict[str, tuple[str, Any]] = {
    "evaluations": ("a positive whole number", Integral),
    "seconds": ("a positive number", Real),
    "solves": ("a positive whole number", Integral),
    "target": ("a finite number", Real),
}


@dataclass(frozen=True, kw_only=True)
class Budget:
    """Limits of one run; it ends at whichever comes first, and at least one is given.

    A candidate's value is one evaluation, value and gradient are two, a Jacobian is two.
    """

    evaluations: int | None = None  #: candidate evaluations
    seconds: float | None = None  #: seconds on the wall, added up over resumes
    #: Solves: one for each candidate and training load case, and another one for its derivatives.
    solves: int | None = None
    target: float | None = None  #: the run ends at the first value that is not above this

    def __post_init__(self) -> None:
        limits = asdict(self)
        if all(limit is None for limit in limits.values()):
            raise UserError("a run needs a limit and none came; give evaluations, seconds, solves or a target.")
        for name, limit in limits.items():
            if limit is not None:
                object.__setattr__(self, name, _limit(name, limit))


def _limit(name: str, limit: Any) -> int | float:
    """The limit as a plain number, if it is a legal one."""
    wanted, kind = _KINDS[name]
    legal = isinstance(limit, kind) and not isinstance(limit, bool) and math.isfinite(limit)
    if not legal or (limit <= 0 and name != "target"):
        raise UserError(f"the budget's {name} must be {wanted}, not {limit!r}; give another limit.")
    return int(limit) if kind is Integral else float(limit)
