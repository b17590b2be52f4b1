"""The scene: everything that states a problem, checked."""

from __future__ import annotations

import hashlib
import json
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, model_validator

from springopt.scene.effect_tables import EffectTable
from springopt.scene.encoding_tables import EncodingTable
from springopt.scene.lattice_tables import LatticeTable
from springopt.scene.load_case_tables import LoadCasesTable
from springopt.scene.reference_tables import ReferenceTable
from springopt.scene.table import Table, fault

if TYPE_CHECKING:
    from springopt.forward.motion.stepping import Stepping
    from springopt.scene.build import Setup

Positive = Annotated[float, Field(gt=0)]
PositiveCount = Annotated[int, Field(gt=0)]


def _as_it_is_called_now(kinematics: Any) -> Any:
    """Exact kinematics were called nonlinear; scenes and run files of then stay good."""
    return "exact" if kinematics == "nonlinear" else kinematics


class ObjectiveTable(Table):
    """What is minimized over the training load cases."""

    minimize: Literal["distance", "relative-distance", "least-squares"] = "distance"
    tolerance: Annotated[float, Field(gt=0, lt=1)] = 1e-8
    cost_cap: Positive | None = None


class BudgetTable(Table):
    """Where a run ends, if the command line does not say otherwise."""

    evaluations: PositiveCount | None = None
    solves: PositiveCount | None = None
    seconds: Positive | None = None
    target: float | None = None


class SteppingTable(Table):
    """How motion goes on in time, where load cases have times."""

    step: Positive
    integrator: Literal["energy-momentum", "l-stable"] = "energy-momentum"
    step_error: Positive | None = None

    def build(self) -> Stepping:
        from springopt.forward.motion.stepping import Stepping

        return Stepping(**self.model_dump())


class Scene(Table):
    """A checked scene, complete in itself: what it extends is merged in, and mesh files are read."""

    name: Annotated[str, Field(pattern=r"^[^/\\]+$")]
    title: str
    group: str | None = None
    lattice: LatticeTable
    kinematics: Annotated[Literal["exact", "linear"], BeforeValidator(_as_it_is_called_now)] = "exact"
    engine: Literal["lanes", "sparse", "iterative"] | None = None
    stepping: SteppingTable | None = None
    branch: Literal["minimum", "followed"] = "minimum"
    effects: list[EffectTable] = Field(default_factory=list)
    load_cases: LoadCasesTable
    reference: ReferenceTable
    encoding: EncodingTable
    objective: ObjectiveTable = ObjectiveTable()
    budget: BudgetTable = BudgetTable()
    optimizers: dict[str, dict[str, Any]] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _times_and_steps_belong_together(self) -> Self:
        if self.load_cases.times is not None and self.stepping is None:
            raise fault("has load cases with times, but no [stepping]; state a step there, or leave the times out")
        if self.load_cases.times is None and self.stepping is not None:
            raise fault("has [stepping], but its load cases have no times; give load_cases.times, or leave it out")
        return self

    def build(self, *, threads: int = 1) -> Setup:
        """The lattice, load cases, reference positions, model, encoding and objective that the scene states.

        `threads` as in `Model`.
        """
        from springopt.scene.build import build

        return build(self, threads=threads)

    def optimizer_options(self, optimizer: str) -> dict[str, Any]:
        """What the scene sets for this optimizer."""
        return dict(self.optimizers.get(optimizer, {}))

    def to_json(self) -> str:
        """The scene as text that `from_json` reads, without any other file."""
        return self.model_dump_json(exclude_none=True)

    def digest(self) -> str:
        """Of what decides the scene's values: not its name, title and group, budget, optimizers and test load cases."""
        tables = self._deciding_tables()
        tables["load_cases"].pop("test", None)
        return _digest(tables)

    def digest_with_tests(self) -> str:
        """Of what decides a run's test errors too: `digest` and the test load cases."""
        return _digest(self._deciding_tables())

    @classmethod
    def from_json(cls, text: str) -> Scene:
        """The scene that `to_json` wrote."""
        from springopt.scene.load import read_json

        return read_json(text)

    def _deciding_tables(self) -> dict[str, Any]:
        beside: Any = {"name", "title", "group", "budget", "optimizers"}
        return self.model_dump(mode="json", exclude_defaults=True, exclude=beside)


def _digest(tables: dict[str, Any]) -> str:
    return hashlib.blake2b(json.dumps(tables, sort_keys=True).encode(), digest_size=16).hexdigest()
