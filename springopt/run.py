"""A run: one optimizer, one scene, one seed; what it was asked to do, and what came of it."""

from __future__ import annotations

import json
import math
from dataclasses import asdict, dataclass, field, fields, is_dataclass
from typing import Any, Literal, NamedTuple

import numpy as np

from springopt.checks import Floats
from springopt.front import Front

WhyStopped = Literal["budget", "target", "optimizer finished", "interrupted"]


class Improvement(NamedTuple):
    """A value lower than all before, and what the run had spent when it came."""

    evaluations: int
    solves: int
    seconds: float  #: on the wall
    processor_seconds: float
    value: float


class LooseSelections(NamedTuple):
    """How often the best of a batch were selected by a loose tolerance, and what comparing told; see `fidelity`."""

    loosest_tolerance: float  #: that was allowed
    made: int
    compared: int  #: of these, with the same by the scene's own tolerance
    differed: int  #: of these, in which were selected, or in their order


@dataclass(frozen=True, kw_only=True)
class Order:
    """What a run is asked to do, and the build that does it: with the answers, all that resuming needs."""

    scene: str  #: the whole scene as JSON
    optimizer: str
    options: dict[str, Any]
    seed: int
    budget: dict[str, Any]  #: the fields of a Budget
    origin: dict[str, str]  #: see `springopt.origin`
    start: dict[str, Any] | None = None  #: name and options of what runs first, see `springopt.start`
    loosest_tolerance: float | None = None  #: of forward solves in `Problem.best_of`; None is the scene's own

    def to_json(self) -> str:
        return json.dumps(asdict(self))

    @classmethod
    def from_json(cls, text: str) -> Order:
        return cls(**json.loads(text))


@dataclass(frozen=True, kw_only=True, eq=False)
class Run:
    """What came of a run."""

    objective: float  #: the lowest value found
    evaluations: int
    solves: int
    seconds: float  #: on the wall, added up over resumes
    processor_seconds: float
    solving_seconds: float  #: of these, within forward solves and derivatives; the others are the optimizer's
    stiffness: Floats  #: of the best candidate [force/length], shape (s,); 0 where there is no spring
    point: Floats  #: the same as the optimizer sees it, shape (size,)
    classes: dict[str, Any]  #: its classes of springs, as the encoding describes them
    errors: list[dict[str, Any]]  #: one for each load case: name, role, distances, status
    optimizer: str
    options: dict[str, Any]
    scene: str
    seed: int
    run: str | None  #: path of the run file
    complete: bool  #: False if it was interrupted and can be resumed
    why_stopped: WhyStopped
    history: list[Improvement]
    parameters: dict[str, list[float]] = field(default_factory=dict)  #: of effects, where they were fitted, by name
    parameter_intervals: dict[str, list[float]] = field(default_factory=dict)  #: lower and upper bound of each of these
    #: The same of the reference, where it is a mass-spring model: what there was to be found.
    reference_parameters: dict[str, list[float]] = field(default_factory=dict)
    #: The objective with the present springs alone, where the threshold of the encoding would drop some.
    objective_of_present: float | None = None
    #: What the optimizer noted, as (evaluations spent, number).
    notes: dict[str, list[tuple[int, float]]] = field(default_factory=dict)
    start: str | None = None  #: the optimizer that ran first, or the run whose best point was the first guess
    scene_digest: str | None = None  #: of what decides the scene's values, see `Scene.digest`
    front: Front = field(default_factory=Front)  #: empty where the optimizer asked for values alone
    #: The loosest tolerance that was allowed, and how often the best were selected loosely; None where it was not.
    loose_selections: LooseSelections | None = None

    @property
    def method(self) -> str:
        """The optimizer and where it began, for people."""
        return f"{self.optimizer} from {self.start}" if self.start else self.optimizer

    def timeless(self) -> dict[str, Any]:
        """Its facts without times and path: on the same build and processor type equal orders give equal ones."""
        facts = asdict(self)
        for name in ("seconds", "processor_seconds", "solving_seconds", "run"):
            del facts[name]
        facts["history"] = [(each.evaluations, each.solves, each.value) for each in self.history]
        return facts

    def to_json(self) -> str:
        """The run as one JSON object; numbers that are not finite are null."""
        return json.dumps(plain(self), allow_nan=False)


def plain(value: Any) -> Any:
    """What JSON can hold of a value: dataclasses and arrays taken apart; numbers that are not finite are null."""
    if is_dataclass(value):
        return {item.name: plain(getattr(value, item.name)) for item in fields(value)}
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, Improvement | LooseSelections):
        return plain(value._asdict())
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
