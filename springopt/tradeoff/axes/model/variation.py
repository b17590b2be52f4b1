"""Variations of a scene: other encodings, and other springs on the same nodes, which learn the same positions."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from springopt.cells import edges, node_pairs
from springopt.checks import Integers
from springopt.errors import UserError
from springopt.lattice import SpringLattice
from springopt.objective import Objective
from springopt.reference.spring import SpringReference
from springopt.scene import Scene, Setup
from springopt.scene.build import build_model
from springopt.scene.encoding_tables import BinaryTable, GroupedTable, RealTable
from springopt.scene.lattice_tables import GridTable, LatticeTable, NodesTable

FREE = "real"
CLASSES = ("homogeneous", "two-class", "three-class")  # the fewest numbers first
#: Springs join neighbours on a grid: a name, and what the scene's [lattice] says.
NEIGHBOURHOODS: dict[str, dict[str, Any]] = {
    "von-neumann": {"neighbourhood": "von-neumann", "radius": 1},
    "face-diagonal": {"neighbourhood": "face-diagonal", "radius": 1},
    "moore": {"neighbourhood": "moore", "radius": 1},
    "moore, radius 2": {"neighbourhood": "moore", "radius": 2},
}
WIDER = 2.0  # the largest stiffness of a real encoding, over that of the bits in whose place it is


@dataclass(frozen=True, eq=False)
class Variation:
    """A scene that differs from the one that was given in one thing, made ready."""

    series: str
    name: str
    setup: Setup
    states: Mapping[str, Any] = field(default_factory=dict)  #: as in `tradeoff.point.Setting`
    is_stated: bool = False
    is_apart: bool = False  #: as in `tradeoff.point.Setting`


@dataclass(frozen=True, eq=False)
class Variations:
    """What there is of a series, and sentences on what there is not."""

    of: tuple[Variation, ...] = ()
    notes: tuple[str, ...] = ()


def encodings(setup: Setup) -> Variations:
    """One class of springs, two, three, and each spring on its own; and the bits of a scene that has them."""
    kinds = (*CLASSES, FREE, *(["binary"] if setup.scene.encoding.kind == "binary" else []))
    found: list[Variation] = []
    notes: list[str] = []
    for kind in kinds:
        try:
            varied = on_same_nodes(setup, with_encoding(setup.scene, kind))
        except UserError as error:
            notes.append(f"The series encodings has no {kind}: {error}")
            continue
        stated = kind == setup.scene.encoding.kind
        found.append(Variation("encodings", _said(kind), varied, {"encoding.kind": kind}, stated))
    if setup.scene.encoding.kind == "binary":
        notes.append(
            f"The scene's springs are present or absent; where they have a stiffness of their own here, it is up to "
            f"{WIDER:g} times that of one that is present."
        )
    return Variations(tuple(found), tuple(notes))


def neighbourhoods(setup: Setup) -> Variations:
    """More and fewer springs on the same nodes, each with a stiffness of its own."""
    found: list[Variation] = []
    notes: list[str] = []
    for name, table, states in _spring_tables(setup):
        try:
            scene = with_encoding(setup.scene, FREE).model_copy(update={"lattice": table})
            varied = on_same_nodes(setup, scene)
        except UserError as error:
            notes.append(f"The series neighbourhood has no {name}: {error}")
            continue
        is_same = np.array_equal(varied.lattice.springs, setup.lattice.springs)
        stated = is_same and setup.scene.encoding.kind == FREE
        found.append(Variation("neighbourhood", name, varied, {**states, "encoding.kind": FREE}, stated))
    if not found and not notes:
        notes.append("There is no series neighbourhood, as the lattice has no cells that would say who is neighbour.")
    return Variations(tuple(found), tuple(notes))


def with_encoding(scene: Scene, kind: str) -> Scene:
    """The same scene with another encoding: its bounds and fitted parameters stay."""
    table = scene.encoding
    if kind == table.kind:
        return scene
    if isinstance(table, BinaryTable):
        lower, upper = 0.0, WIDER * float(np.max(table.stiffness))
    else:
        lower, upper = table.lower, table.upper
    parameters = [each.model_dump() for each in table.parameters]
    other = RealTable if kind == FREE else GroupedTable
    tables = {"kind": kind, "lower": lower, "upper": upper, "parameters": parameters}
    return scene.model_copy(update={"encoding": other.model_validate(tables)})


def on_same_nodes(setup: Setup, scene: Scene) -> Setup:
    """A scene that differs in springs and encoding, made ready: it learns the positions that are known already.

    So a mass-spring reference stays the one of the springs that it was stated with, and noise the noise.

    Raises:
        UserError: where effects or encoding do not fit the springs.
    """
    is_same = scene.lattice == setup.scene.lattice
    reference = setup.objective.reference
    # The springs of another lattice are not those of the reference.
    kept = None if isinstance(reference, SpringReference) and not is_same else reference
    return made_ready(scene, setup.lattice if is_same else scene.lattice.build(), setup.reference_positions, kept)


def made_ready(scene: Scene, lattice: SpringLattice, positions: Any, reference: Any = None) -> Setup:
    """The setup of a scene whose reference positions, shape (c, n, d) or (c, t, n, d), are known."""
    model = build_model(scene, lattice)
    encoding = scene.encoding.build_for(model)
    cases = scene.load_cases.build(lattice)
    objective = Objective(model, cases, positions, reference=reference, **scene.objective.model_dump())
    return Setup(scene, lattice, model, cases, positions, encoding, objective)


def _said(kind: str) -> str:
    return "free" if kind == FREE else kind


def _spring_tables(setup: Setup) -> Iterator[tuple[str, LatticeTable, dict[str, Any]]]:
    """Names, tables, and what a scene states, for the springs that the nodes may have."""
    table, lattice = setup.scene.lattice, setup.lattice
    if isinstance(table, GridTable):
        stated = {"neighbourhood": table.neighbourhood, "radius": table.radius}
        wanted = dict(NEIGHBOURHOODS)
        if lattice.dimension == 2:  # where all diagonals are those of faces
            wanted.pop("face-diagonal")
        if stated not in wanted.values() and (lattice.dimension, stated["radius"]) != (2, 1):
            wanted[f"{table.neighbourhood}, radius {table.radius}"] = stated
        for name, keys in wanted.items():
            said = {f"lattice.{key}": value for key, value in keys.items()}
            yield name, GridTable.model_validate(table.model_dump() | keys), said
    elif lattice.cells is not None and lattice.cell_type is not None:
        few, many = edges(lattice.cells, lattice.cell_type), node_pairs(lattice.cells)
        yield "edges", _joined(lattice, few), {"lattice.neighbourhood": "edges"}
        if len(many) > len(few):  # of simplices they are the same
            yield "cells", _joined(lattice, many), {"lattice.neighbourhood": "cells"}


def _joined(lattice: SpringLattice, springs: Integers) -> NodesTable:
    """The nodes and cells of a lattice with these springs, shape (s, 2), as long at rest as they are apart."""
    return NodesTable.of(SpringLattice(lattice.nodes, springs, cells=lattice.cells, cell_type=lattice.cell_type))
