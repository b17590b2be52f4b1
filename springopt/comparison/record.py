"""What a comparison keeps of a run: what it reached, when, and what it spent."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from springopt.checks import Floats
from springopt.run import Order, Run

#: What a running time is counted in, always all three: nobody hides behind a unit.
UNITS = ("evaluations", "solves", "processor_seconds")


@dataclass(frozen=True, kw_only=True, eq=False)
class Record:
    """A complete run, for comparing."""

    path: Path
    scene: str
    digest: str | None  #: of what decides the scene's values
    tests: str  #: digest of its test load cases, which decide no value
    minimize: str  #: the scene's misfit
    label: str  #: what the optimizer is called, whatever its settings
    method: str  #: the same, with what sets it apart in this comparison from others of its label
    optimizer: str
    seed: int
    options: dict[str, Any]
    start: str | None  #: what ran first
    budget: dict[str, float]  #: the limits that were set
    processor: str  #: the type of processor that it ran on
    build: dict[str, str]  #: versions of what took part in the arithmetic, see `springopt.origin`
    values: Floats  #: the best value at each improvement, falling, shape (i,)
    spent: dict[str, Floats]  #: when each improvement came, by unit, shape (i,)
    total: dict[str, float]  #: what the whole run spent, by unit
    solving_seconds: float  #: of its processor seconds, within forward solves and derivatives
    train_error: float  #: see `mean_error`
    test_error: float | None
    why_stopped: str

    @property
    def value(self) -> float:
        return float(self.values[-1])

    def time_to(self, value: float, unit: str) -> float:
        """What had been spent when the run was first at or below a value; inf if it never was."""
        reached = int(np.searchsorted(-self.values, -value))
        return float(self.spent[unit][reached]) if reached < len(self.values) else math.inf

    def is_like(self, other: Record) -> bool:
        """Whether both runs took the same course to the bit, whatever their seeds; times apart.

        Of a run that a limit of seconds may have ended early, as far as it went.
        """
        shorter = min(self, other, key=lambda run: run.total["evaluations"])
        until = shorter.total["evaluations"]
        ended_alike = self.total["evaluations"] == other.total["evaluations"]
        if not ended_alike and not (shorter.why_stopped == "budget" and "seconds" in shorter.budget):
            return False
        return all(np.array_equal(*pair) for pair in zip(self._course(until), other._course(until), strict=True))

    def _course(self, until: float) -> tuple[Floats, Floats]:
        """Evaluations and values of the improvements up to some evaluations."""
        count = int(np.searchsorted(self.spent["evaluations"], until, side="right"))
        return self.spent["evaluations"][:count], self.values[:count]


def record_of(order: Order, run: Run, path: Path, label: str) -> Record:
    """A run as the comparison needs it."""
    spent = {unit: np.array([getattr(each, unit) for each in run.history], dtype=float) for unit in UNITS}
    return Record(
        path=path,
        scene=run.scene,
        digest=run.scene_digest,
        tests=_facts_of(order.scene).tests,
        minimize=_facts_of(order.scene).minimize,
        label=label,
        method=label,
        optimizer=run.optimizer,
        seed=run.seed,
        options=order.options,
        start=run.start,
        budget={name: limit for name, limit in order.budget.items() if limit is not None},
        processor=order.origin.get("processor", "unknown"),
        build={name: made for name, made in order.origin.items() if name != "processor"},
        values=np.array([each.value for each in run.history]),
        spent=spent,
        total={unit: float(getattr(run, unit)) for unit in UNITS},
        solving_seconds=run.solving_seconds,
        train_error=mean_error(run.errors, "train") or 0.0,
        test_error=mean_error(run.errors, "test"),
        why_stopped=run.why_stopped,
    )


def mean_error(errors: Sequence[dict[str, Any]], role: str) -> float | None:
    """Mean over the load cases of a role of the mean distance of the nodes over the smallest rest length.

    The same measure for every scene, whatever it minimizes, and for training and test alike. None without such load
    cases, inf where one has no equilibrium.
    """
    distances = [error["relative_distance"] for error in errors if error["role"] == role]
    if not distances:
        return None
    mean = float(np.mean([math.inf if each is None else each for each in distances]))
    return math.inf if math.isnan(mean) else mean


class _Facts(NamedTuple):
    minimize: str
    tests: str


@lru_cache(maxsize=64)
def _facts_of(scene: str) -> _Facts:
    tables = json.loads(scene)
    tests = json.dumps(tables["load_cases"].get("test", []), sort_keys=True)
    return _Facts(tables["objective"]["minimize"], hashlib.blake2b(tests.encode(), digest_size=16).hexdigest())
