"""[load_cases]: what is held, pushed and moved, by names of sides or numbers of nodes."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    PlainValidator,
    ValidationInfo,
    field_validator,
    model_validator,
)

from springopt.checks import Booleans, Floats
from springopt.errors import SceneError
from springopt.lattice import SpringLattice
from springopt.load_case import LoadCase
from springopt.scene.selection import AXES, axis_numbers, parse_axes, parse_selection, select_nodes
from springopt.scene.table import FittingTable, Table, fault, lattice_of

Selection = Annotated[list[str | int], PlainValidator(parse_selection)]
Axes = Annotated[list[str], PlainValidator(parse_axes)]
Vector = list[float]


class Hold(Table):
    """Supports: these nodes do not move along these axes (all, if not said)."""

    on: Selection
    axes: Axes | None = None

    def degrees_of_freedom(self, lattice: SpringLattice) -> Booleans:
        """Mask, shape (n, d)."""
        held = np.zeros((lattice.node_count, lattice.dimension), dtype=bool)
        held[:, axis_numbers(lattice, self.axes)] = select_nodes(lattice, self.on)[:, None]
        return held


class Push(Table):
    """Nodal forces: `force` on each node, or `total` spread evenly over them."""

    on: Selection
    force: Vector | None = None
    total: Vector | None = None

    @field_validator("force", "total")
    @classmethod
    def _fits_dimension(cls, vector: Vector | None, info: ValidationInfo) -> Vector | None:
        lattice = lattice_of(info)
        if vector is not None and lattice is not None and len(vector) != lattice.dimension:
            raise fault(f"should have one number for each of {lattice.dimension} axes, but is {vector}")
        return vector

    @model_validator(mode="after")
    def _one_of_force_and_total(self) -> Push:
        if (self.force is None) == (self.total is None):
            raise fault("should have one of force (on each node) and total (spread evenly)")
        return self

    def forces(self, lattice: SpringLattice) -> Floats:
        """Nodal forces, shape (n, d)."""
        nodes = select_nodes(lattice, self.on)
        vector = np.array(self.force) if self.force is not None else np.array(self.total) / nodes.sum()
        return np.outer(nodes, vector)


class Move(Table):
    """Prescribed displacements: these nodes move by this much along these axes (all, if not said)."""

    on: Selection
    axes: Axes | None = None
    by: Vector

    @field_validator("by")
    @classmethod
    def _fits_axes(cls, by: Vector, info: ValidationInfo) -> Vector:
        lattice, axes = lattice_of(info), info.data.get("axes")
        names = axes or (AXES[: lattice.dimension] if lattice is not None else None)
        if names is not None and len(by) != len(names):
            raise fault(f"should have one number for each of the axes {', '.join(names)}, but is {by}")
        return by

    def displacements(self, lattice: SpringLattice) -> Floats:
        """Prescribed displacements, shape (n, d), NaN where nothing is prescribed."""
        row = np.full(lattice.dimension, np.nan)
        row[axis_numbers(lattice, self.axes)] = self.by
        return np.where(select_nodes(lattice, self.on)[:, None], row, np.nan)


def _holds(value: Any) -> Any:
    """`hold = "left"`, `hold = ["left", 7]` and `hold = {on = "left"}` are short for a list of tables."""
    is_tables = isinstance(value, list) and all(isinstance(entry, dict | Hold) for entry in value)
    if is_tables:
        return value
    return [value] if isinstance(value, dict) else [{"on": value}]


def _tables(value: Any) -> Any:
    return [value] if isinstance(value, dict) else value


class LoadCaseTable(FittingTable):
    """One load case."""

    name: Annotated[str, Field(min_length=1)]
    hold: Annotated[list[Hold], BeforeValidator(_holds)] = Field(default_factory=list)
    push: Annotated[list[Push], BeforeValidator(_tables)] = Field(default_factory=list)
    move: Annotated[list[Move], BeforeValidator(_tables)] = Field(default_factory=list)

    def try_on(self, lattice: SpringLattice) -> object:
        return self.build(lattice, "train")

    def build(self, lattice: SpringLattice, role: Literal["train", "test"]) -> LoadCase:
        shape = (lattice.node_count, lattice.dimension)
        supports = np.zeros(shape, dtype=bool)
        for hold in self.hold:
            supports |= hold.degrees_of_freedom(lattice)
        prescribed = self._prescribed(lattice, supports)
        if not np.isfinite(prescribed).any():
            raise SceneError(f"load case {self.name!r} has no supports; name a side to hold, or it floats away")
        forces = sum((push.forces(lattice) for push in self.push), np.zeros(shape))
        return LoadCase(self.name, supports, forces, prescribed=prescribed, role=role)

    def _prescribed(self, lattice: SpringLattice, supports: Booleans) -> Floats:
        prescribed = np.where(supports, 0.0, np.nan)
        for move in self.move:
            displacements = move.displacements(lattice)
            twice = np.isfinite(displacements) & np.isfinite(prescribed)
            if twice.any():
                node, axis = np.argwhere(twice)[0]
                raise SceneError(
                    f"load case {self.name!r} prescribes {AXES[axis]} of node {node} twice, to "
                    f"{prescribed[node, axis]:g} and {displacements[node, axis]:g}; hold or move it once"
                )
            prescribed = np.where(np.isfinite(displacements), displacements, prescribed)
        return prescribed


class EvenTimes(Table):
    """So many times, evenly spaced from after 0 until the last one."""

    until: Annotated[float, Field(gt=0)]
    count: Annotated[int, Field(gt=0)]


def _times(value: Any) -> Any:
    """`times = { until = 2.0, count = 20 }` is short for the list."""
    if isinstance(value, dict):
        table = EvenTimes.model_validate(value)
        return [table.until * number / table.count for number in range(1, table.count + 1)]
    return value


def _ascending(times: list[float]) -> list[float]:
    if not all(before < after for before, after in pairwise([0.0, *times])):
        raise fault(f"should ascend from above 0, but is {times}")
    return times


Times = Annotated[list[float], Field(min_length=1), BeforeValidator(_times), AfterValidator(_ascending)]


class LoadCasesTable(Table):
    """Load cases to learn from, and load cases that only judge what was learned."""

    train: Annotated[list[LoadCaseTable], Field(min_length=1)]
    test: list[LoadCaseTable] = Field(default_factory=list)
    #: Multiplies every force and prescribed displacement: one number to make a scene gentler or harder.
    scale: Annotated[float, Field(gt=0)] = 1.0
    #: When motion is looked at; without times load cases are static.
    times: Times | None = None

    @model_validator(mode="after")
    def _names_differ(self) -> LoadCasesTable:
        names = [case.name for case in self.train + self.test]
        repeated = sorted({name for name in names if names.count(name) > 1})
        if repeated:
            raise fault(f"should give every load case a name of its own, but repeats {', '.join(map(repr, repeated))}")
        return self

    def build(self, lattice: SpringLattice) -> list[LoadCase]:
        tables: list[tuple[LoadCaseTable, Literal["train", "test"]]]
        tables = [(case, "train") for case in self.train] + [(case, "test") for case in self.test]
        return [_scaled(table.build(lattice, role), self.scale, self.times) for table, role in tables]


def _scaled(case: LoadCase, scale: float, times: list[float] | None) -> LoadCase:
    moment = None if times is None else np.array(times)
    return replace(case, forces=scale * case.forces, prescribed=scale * case.prescribed, times=moment)
