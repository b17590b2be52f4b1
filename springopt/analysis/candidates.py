"""Load cases to choose from: those of a scene, or every pull and shear of a side while another one is held."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from springopt.checks import Floats, Integers
from springopt.errors import UserError
from springopt.lattice import SpringLattice, side, side_names
from springopt.load_case import LoadCase
from springopt.model import Model, Solution
from springopt.scene import Scene, Setup
from springopt.scene.load_case_tables import LoadCaseTable

AXES = "xyz"
EXACT = 1e-12  # tolerance of solves whose difference matters
SMALL = 1e-6  # load of a probe, over stiffness times size: its answer is linear


@dataclass(frozen=True, eq=False)
class Candidate:
    """A load case that may be added, and as a scene would state it, if it was made here."""

    case: LoadCase
    table: dict[str, Any] | None = None


def candidates_of(scene: Scene, setup: Setup, *, test_alone: bool) -> list[Candidate]:
    """The load cases of a scene with the same nodes as the setup's: its test load cases, or all."""
    lattice = scene.lattice.build()
    if not np.array_equal(lattice.nodes, setup.lattice.nodes):
        raise UserError(
            f"the candidates of {scene.name} are for other nodes than those of {setup.scene.name}; "
            f"let the scene of candidates extend {setup.scene.name}."
        )
    cases = scene.load_cases.build(lattice)
    chosen = [Candidate(case) for case in cases if case.role == "test" or not test_alone]
    if not chosen:
        raise UserError(f"{scene.name} has no test load cases to choose from; choose from the generated ones.")
    return chosen


def generated(setup: Setup, row: Floats) -> list[Candidate]:
    """Every side held, another one or a corner loaded along each axis; those without an equilibrium are left out.

    Each load is so large that the furthest node moves as far as in the median of the training load cases, to first
    order in the load. They have the times of the training load cases, if these have any.
    """
    model, training = setup.model, [case for case in setup.cases if case.role == "train"]
    reach, times = float(np.median(_furthest(model, row, training))), training[0].times
    if not reach > 0:
        raise UserError("the training load cases move nothing, so that loads to choose from have no size; give some.")
    probe = SMALL * float(row[: setup.lattice.spring_count].max()) * float(np.ptp(setup.lattice.nodes, axis=0).max())
    tables = list(_tables(setup.lattice, probe))
    moved = _furthest_by_load(model, row, [_case(table, setup.lattice, times) for table in tables])
    sized = [_scaled(table, reach / far) for table, far in zip(tables, moved, strict=True) if 0 < far < np.inf]
    return [Candidate(_case(table, setup.lattice, times), table) for table in sized]


def _tables(lattice: SpringLattice, force: float) -> Iterator[dict[str, Any]]:
    """The load cases as a scene states them, each with this much force; pulls, not pushes, along a side's normal."""
    masks = {name: side(lattice, name) for name in side_names(lattice)}
    corners = np.flatnonzero(sum(mask.astype(int) for mask in masks.values()) >= lattice.dimension)
    for held, mask in masks.items():
        for other in masks:
            if other != held:
                yield from _along_axes(lattice, held, other, np.flatnonzero(masks[other]), force)
        for corner in corners[~mask[corners]].tolist():
            yield from _along_axes(lattice, held, corner, np.array([corner]), force)


def _along_axes(
    lattice: SpringLattice, held: str, on: str | int, nodes: Integers, force: float
) -> Iterator[dict[str, Any]]:
    outward = lattice.nodes[nodes].mean(axis=0) - (lattice.nodes.min(axis=0) + lattice.nodes.max(axis=0)) / 2
    for axis in range(lattice.dimension):
        total = [0.0] * lattice.dimension
        total[axis] = -force if outward[axis] < 0 else force
        where = on if isinstance(on, str) else f"node {on}"
        name = f"hold {held}, load {where} along {AXES[axis]}"
        yield {"name": name, "hold": held, "push": {"on": on, "total": total}}


def _case(table: dict[str, Any], lattice: SpringLattice, times: Floats | None) -> LoadCase:
    case = LoadCaseTable.model_validate(table, context={"lattice": lattice}).build(lattice, "train")
    return replace(case, times=times)


def _scaled(table: dict[str, Any], factor: float) -> dict[str, Any]:
    total = [float(f"{factor * component:.4g}") for component in table["push"]["total"]]
    return table | {"push": table["push"] | {"total": total}}


def _furthest(model: Model, row: Floats, cases: list[LoadCase]) -> Floats:
    """How far the furthest node of each load case moves, at any time, shape (c,); inf without an equilibrium."""
    return _reach(solution := model.solve(row, cases), solution.displacements)


def _furthest_by_load(model: Model, row: Floats, cases: list[LoadCase]) -> Floats:
    """As `_furthest`, of small forces alone: without what weights and the like do to the body anyway."""
    if not model.effects:
        return _furthest(model, row, cases)
    solution = model.solve(row, cases, EXACT)
    unloaded = model.solve(row, [replace(case, forces=np.zeros_like(case.forces)) for case in cases], EXACT)
    return _reach(solution, solution.displacements - unloaded.displacements)


def _reach(solution: Solution, displacements: Floats) -> Floats:
    far = np.linalg.norm(displacements, axis=-1).reshape(len(displacements), -1).max(axis=-1)
    return np.where([status.has_equilibrium for status in solution.status], far, np.inf)
