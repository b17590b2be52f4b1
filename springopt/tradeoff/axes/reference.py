"""Elements of the reference: how far those of a scene are from the body that they stand for, and what finer ones cost.

All meshes are nested and bear one load, see `springopt.reference.refinement`, and are compared at the lattice's own
nodes. What judges are second-order elements on a mesh finer than those of second order that are judged, and as fine as
the finest of first order, which share no shape function with them; where there are three meshes of them, extrapolated
to cells of no size (Richardson 1911), since corners make even them converge slowly. Of the judge itself first-order
elements tell independently, extrapolated alike.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from springopt.checks import Floats
from springopt.errors import UserError
from springopt.load_case import LoadCase
from springopt.reference import Reference
from springopt.reference.refinement import Refinement
from springopt.scene import Scene, Setup
from springopt.scene.build import build_model
from springopt.scene.lattice_tables import GridTable
from springopt.scene.reference_tables import FemTable
from springopt.tradeoff.errors import relative_errors
from springopt.tradeoff.interval import Interval
from springopt.tradeoff.point import Axis, Findings, Request, Setting, measure_settings

SERIES = {1: "first order", 2: "second order"}
#: Of the displacements of a smooth solution, in the size of the cells (Strang and Fix 1973, section 3.2).
THEORY = {1: 2.0, 2: 3.0}
MOST_UNKNOWNS = {2: 100_000, 3: 20_000}  # by dimension: factors are of some gigabytes then
MOST_UNKNOWNS_IN_MOTION = 3_000  # all modes are found, with full matrices
#: The power of the unknowns that time grows with, from the assembly's to the factor's, by dimension and order.
GROWTH = {(2, 1): 1.2, (2, 2): 1.2, (3, 1): 1.2, (3, 2): 1.5}
GROWTH_IN_MOTION = 3.0
LEAST_RUNS = 4  # of what is measured: two that warm up, one that is timed, one that is judged
ROUNDING = 1e-12  # no order of convergence is read off errors below

MOST_LEVELS = 20
LEAST_RATIO, MOST_RATIO = 1.5, 50.0  # of the last two steps, for an extrapolation to be worth anything

Answer = Floats | UserError
_Errors = dict[tuple[int, int], Floats]  # of the load cases, by order and level


@dataclass(frozen=True, eq=False)
class _Trial:
    """Elements that were tried once."""

    order: int
    level: int  #: how often the cells of the lattice are divided
    table: FemTable
    answers: Sequence[Answer]  #: positions [length], (n, d) or (t, n, d), or why there are none, a load case each
    unknowns: int
    seconds: float

    @property
    def is_complete(self) -> bool:
        return not any(isinstance(answer, UserError) for answer in self.answers)

    @property
    def why(self) -> str:
        """The first load case that failed."""
        return next((str(answer) for answer in self.answers if isinstance(answer, UserError)), "")


@dataclass(frozen=True, eq=False)
class _Judge:
    """The finest elements that answer every load case."""

    trial: _Trial
    positions: Sequence[Floats]  #: extrapolated where that is worth anything, a load case each
    extrapolated: int  #: how many are

    def is_finer(self, trial: _Trial) -> bool:
        return (trial.level, trial.order) < (self.trial.level, self.trial.order)


def _missing(scene: Scene) -> str | None:
    if not isinstance(scene.reference, FemTable):
        return "its reference is a mass-spring model, which has no elements"
    try:
        finer = scene.reference.model_copy(update={"refinements": max(1, scene.reference.refinements)})
        finer.build(build_model(scene, scene.lattice.build()))
    except UserError as error:
        return str(error).rstrip(".")
    return None


def _measure(setup: Setup, request: Request) -> Findings:
    start = time.perf_counter()
    trials = _trials(setup, request)
    judge = _judge(trials)
    if judge is None:
        return Findings([], notes=[_nothing_judges(trials)])
    judged = [trial for trial in trials if judge.is_finer(trial) or not trial.is_complete]
    errors = {(trial.order, trial.level): _errors(setup, judge, trial, trial.answers) for trial in judged}
    settings = [_setting(setup, judge, trial, errors) for trial in judged]
    left = max(request.seconds - (time.perf_counter() - start), 0.0)
    points = measure_settings(settings, replace(request, seconds=left))
    whys = {_key(setup, trial.order, trial.level): trial.why for trial in judged}
    points = [replace(point, why=whys[point.series, point.name]) for point in points]
    return Findings(points, notes=list(_notes(setup, trials, judge, errors)))


AXIS = Axis(
    name="reference",
    title="Finite elements of the reference",
    error="distance from the finest elements over the displacement",
    time="one load case of the reference",
    missing=_missing,
    measure=_measure,
)


def _trials(setup: Setup, request: Request) -> list[_Trial]:
    """Both orders on finer and finer meshes, as far as there is time left to measure all but the finest elements."""
    begun = time.perf_counter()
    steps = [[(1, 0)], [(2, 0)], *([(1, level), (2, level)] for level in range(1, MOST_LEVELS))]
    # A setting that is asked for needs a finer one that judges it: of second order on the same mesh, or the next one.
    needed = max(level + order - 1 for order, level in _asked(setup, request))
    trials: list[_Trial] = []
    for step in steps:
        foreseen = [_foreseen(setup, trials, order) for order, _ in step] if trials else [(0, 0.0)]
        seconds = time.perf_counter() - begun + sum(seconds for _, seconds in foreseen)
        seconds += LEAST_RUNS * (sum(trial.seconds for trial in trials) + foreseen[0][1] * (len(step) - 1))
        if seconds > request.seconds and step[-1][1] > needed:
            break
        if max(unknowns for unknowns, _ in foreseen) > _most(setup):
            break
        for order, level in step:
            if request.progress:
                request.progress(len(trials), None, f"trying {', '.join(_key(setup, order, level))}")
            trials.append(_tried(setup, order, level))
    return trials


def _asked(setup: Setup, request: Request) -> list[tuple[int, int]]:
    """Order and level of what is asked for by name, and of what the scene states."""
    known = [(order, level) for level in range(MOST_LEVELS) for order in SERIES]
    own = (_stated(setup).order, _stated(setup).refinements)
    return [own, *(entry for entry in known if _key(setup, *entry) in request.only)]


def _foreseen(setup: Setup, trials: Sequence[_Trial], order: int) -> tuple[int, float]:
    """Unknowns, at most, and seconds of the next elements of an order, from the last ones."""
    before = [trial for trial in trials if trial.order == order] or trials
    factor = 2**setup.lattice.dimension  # for cells divided once, and for elements of second order
    is_static = setup.scene.load_cases.times is None
    growth = GROWTH[setup.lattice.dimension, order] if is_static else GROWTH_IN_MOTION
    return before[-1].unknowns * factor, before[-1].seconds * factor**growth


def _most(setup: Setup) -> int:
    is_static = setup.scene.load_cases.times is None
    return MOST_UNKNOWNS[setup.lattice.dimension] if is_static else MOST_UNKNOWNS_IN_MOTION


def _tried(setup: Setup, order: int, level: int) -> _Trial:
    table = _table(setup, order, level)
    begun = time.perf_counter()
    answers = _deformed(setup, table)
    seconds = time.perf_counter() - begun
    unknowns = _refinement(setup, level, order).node_count * setup.lattice.dimension
    return _Trial(order, level, table, answers, unknowns, seconds)


def _table(setup: Setup, order: int, level: int) -> FemTable:
    changes: dict[str, Any] = {"order": order, "refinements": level}
    if order == 2:  # both are for first-order elements, and no part of the body that they stand for
        changes |= {"formulation": "standard", "lumped": False}
    return _stated(setup).model_copy(update=changes)


def _stated(setup: Setup) -> FemTable:
    assert isinstance(setup.scene.reference, FemTable)  # else the axis is missing
    return setup.scene.reference


def _deformed(setup: Setup, table: FemTable) -> list[Answer]:
    """From nothing: assembly and factors are a part of it."""
    reference = table.build(setup.model)
    return [_answer(reference, case) for case in setup.cases]


def _answer(reference: Reference, case: LoadCase) -> Answer:
    try:
        return reference.deform(case)
    except UserError as error:
        return error


def _judge(trials: Sequence[_Trial]) -> _Judge | None:
    """Of second order if any of them are complete; None where there is nothing to judge."""
    complete = [trial for trial in trials if trial.is_complete]
    best = max(complete, key=lambda trial: (trial.order, trial.level), default=None)
    if best is None or best is trials[0]:
        return None
    limits = _limits(trials, best.order)
    pairs = list(zip(limits or best.answers, best.answers, strict=True))
    positions = [_positions(answer if limit is None else limit) for limit, answer in pairs]
    return _Judge(best, positions, sum(limit is not None for limit in limits))


def _limits(trials: Sequence[_Trial], order: int) -> list[Floats | None]:
    """What elements of an order tend to as their cells shrink, a load case each: None where three meshes don't tell.

    The error is taken to shrink at the rate of the last steps, (u2 - u1) / (u3 - u2), whatever makes it that.
    """
    last = [trial.answers for trial in trials if trial.order == order and trial.is_complete][-3:]
    return [_limit(*map(_positions, answers)) for answers in zip(*last, strict=True)] if len(last) == 3 else []


def _limit(coarse: Floats, middle: Floats, fine: Floats) -> Floats | None:
    step = np.linalg.norm(fine - middle)
    ratio = np.linalg.norm(middle - coarse) / step if step else np.inf
    if not LEAST_RATIO <= ratio <= MOST_RATIO:
        return None
    return fine + (fine - middle) / (ratio - 1.0)


def _positions(answer: Answer) -> Floats:
    assert not isinstance(answer, UserError)  # of what is complete
    return answer


def _errors(setup: Setup, judge: _Judge, trial: _Trial, answers: Sequence[Answer]) -> Floats:
    """Of each load case, inf where there is no answer, or nothing that judges it."""
    if not judge.is_finer(trial):
        return np.full(len(answers), np.inf)
    return np.array([_error(setup, *pair) for pair in zip(answers, judge.positions, strict=True)])


def _error(setup: Setup, answer: Answer, known: Floats) -> float:
    """The moments of a motion are taken as more nodes."""
    if isinstance(answer, UserError):
        return np.inf
    nodes = np.broadcast_to(setup.lattice.nodes, known.shape)
    positions, known, nodes = (array.reshape(-1, nodes.shape[-1]) for array in (answer, known, nodes))
    return float(relative_errors(positions, known, nodes))


def _setting(setup: Setup, judge: _Judge, trial: _Trial, errors: _Errors) -> Setting:
    stated, table = _stated(setup).model_dump(), trial.table.model_dump()
    said = {key: value for key, value in table.items() if key in ("order", "refinements") or value != stated[key]}
    numbers = {
        "unknowns": float(trial.unknowns),
        "cells": float(_cell_count(setup, trial.level)),
        "theoretical_order": THEORY[trial.order],
    }
    observed = _observed(errors, trial.order, trial.level)
    if observed is not None:
        numbers["observed_order"] = observed.value
    series, name = _key(setup, trial.order, trial.level)
    return Setting(
        series=series,
        name=name,
        run=partial(_deformed, setup, trial.table),
        judge=partial(_errors, setup, judge, trial),
        solves=len(setup.cases),
        states={f"reference.{key}": value for key, value in said.items()},
        is_stated=table == stated,
        numbers=numbers,
    )


def _key(setup: Setup, order: int, level: int) -> tuple[str, str]:
    """Series and name: the cells along each axis of a grid of blocks, else their number."""
    table = setup.scene.lattice
    if isinstance(table, GridTable) and setup.lattice.cell_type in ("quad", "hexahedron"):
        cells = " x ".join(str((count - 1) * 2**level) for count in table.grid)
    else:
        cells = f"{_cell_count(setup, level):,}"
    return SERIES[order], f"{cells} cells"


def _cell_count(setup: Setup, level: int) -> int:
    assert setup.lattice.cells is not None  # else there are no elements
    return len(setup.lattice.cells) * 2 ** (setup.lattice.dimension * level)


def _observed(errors: _Errors, order: int, level: int) -> Interval | None:
    """The order of convergence between a mesh and the one before it, over the load cases."""
    if (order, level - 1) not in errors or (order, level) not in errors:
        return None
    coarse, fine = errors[order, level - 1], errors[order, level]
    is_told = np.isfinite(coarse) & np.isfinite(fine) & (np.minimum(coarse, fine) > ROUNDING)
    return Interval.of(np.log2(coarse[is_told] / fine[is_told])) if is_told.any() else None


def _notes(setup: Setup, trials: Sequence[_Trial], judge: _Judge, errors: _Errors) -> Iterator[str]:
    series, name = _key(setup, judge.trial.order, judge.trial.level)
    extrapolated = f", in {judge.extrapolated} of {len(judge.positions)} load cases extrapolated from three meshes"
    yield (
        f"Errors are distances from elements of {series} on {name}, with {judge.trial.unknowns:,} unknowns"
        f"{extrapolated if judge.extrapolated else ''}."
    )
    if judge.trial.order == 1:
        yield "No elements of second order answered every load case, so that elements of first order judge their own."
    orders = list(_convergence(errors))
    yield from orders
    if orders:
        yield (
            "Orders are less where stresses are infinite or jump, at corners of held sides and at the ends of loads: "
            "down to 1, and below, at nodes that lie there; at nodes of even meshes they may be more."
        )
    before = errors.get((judge.trial.order, judge.trial.level - 1))
    if before is not None and judge.extrapolated < len(judge.positions):
        yield (
            f"What is not extrapolated is itself off: by {np.median(before):.2g} of the displacement if it converges "
            "with order 1, and less where with more."
        )
    doubts = _doubts(setup, trials, judge)
    if doubts:
        yield (
            f"Elements of first order alone, extrapolated from three meshes, end {np.median(doubts):.2g} of the "
            f"displacement away from that ({max(doubts):.2g} in the worst load case), which measures what is in doubt."
        )
    points = max(_refinement(setup, 0, 1).count_points(case.supports) for case in setup.cases)
    if points:
        yield (
            f"Up to {points} held nodes in a load case fill no side of a cell and stay points, which give way the more "
            "the finer the elements are: unless they carry nothing, there is no limit to converge to."
        )
    if (_stated(setup).order, _stated(setup).refinements) not in errors:
        yield "The scene's own elements are not among them, since too many finer ones would have to judge them."


def _convergence(errors: _Errors) -> Iterator[str]:
    for order, series in SERIES.items():
        level = max((level for kind, level in errors if kind == order), default=0)
        observed = _observed(errors, order, level)
        if observed is not None:
            value, low, high = (f"{number:.2f}" for number in (observed.value, observed.low, observed.high))
            spread = "" if low == high else f" ({low} to {high} over the load cases)"
            yield (
                f"Elements of {series} converge with order {value}{spread} in the last step, where theory has "
                f"{THEORY[order]:g} for smooth solutions."
            )


def _doubts(setup: Setup, trials: Sequence[_Trial], judge: _Judge) -> list[float]:
    """How far from the judge the limits of the first-order elements are, as errors."""
    limits = _limits(trials, 1) if judge.trial.order == 2 else []
    pairs = zip(limits, judge.positions, strict=True) if limits else []
    return [_error(setup, limit, known) for limit, known in pairs if limit is not None]


def _nothing_judges(trials: Sequence[_Trial]) -> str:
    first = trials[0]
    if not first.is_complete:
        return f"No elements answer every load case: {first.why}"
    if len(trials) > 1:
        return f"Finer elements than those of the lattice do not answer every load case: {trials[1].why}"
    return (
        f"With {first.unknowns:,} unknowns on the lattice itself, elements of second order would be too many for the "
        "time that is given, so that nothing judges those of the lattice."
    )


def _refinement(setup: Setup, level: int, order: int) -> Refinement:
    lattice = setup.lattice
    assert lattice.cells is not None
    assert lattice.cell_type is not None
    return Refinement((lattice.nodes, lattice.cells, lattice.cell_type), level, order)
