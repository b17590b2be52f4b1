"""Elements of the reference: how far those of a scene are from the body that they stand for, and what finer ones cost.

Second-order elements on the finest mesh judge, see `springopt.tradeoff.elements`. Of them first-order elements tell
independently, extrapolated to cells of no size.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from springopt.checks import Floats
from springopt.errors import UserError
from springopt.scene import Scene, Setup
from springopt.scene.build import build_model
from springopt.scene.reference_tables import FemTable
from springopt.tradeoff.elements import (
    SERIES,
    Judge,
    Trial,
    cell_count,
    deformed,
    error_of,
    errors_of,
    judge_of,
    key_of,
    limits_of,
    refinement_of,
    stated_table,
    try_elements,
)
from springopt.tradeoff.interval import Interval
from springopt.tradeoff.point import Axis, Findings, Request, Setting, measure_settings

#: Of the displacements of a smooth solution, in the size of the cells (Strang and Fix 1973, section 3.2).
THEORY = {1: 2.0, 2: 3.0}
ROUNDING = 1e-12  # no order of convergence is read off errors below

_Errors = dict[tuple[int, int], Floats]  # of the load cases, by order and level


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
    trials = try_elements(setup, request)
    judge = judge_of(trials)
    if judge is None:
        return Findings([], notes=[_nothing_judges(trials)])
    judged = [trial for trial in trials if judge.is_finer(trial) or not trial.is_complete]
    errors = {(trial.order, trial.level): errors_of(setup, judge, trial, trial.answers) for trial in judged}
    settings = [_setting(setup, judge, trial, errors) for trial in judged]
    left = max(request.seconds - (time.perf_counter() - start), 0.0)
    points = measure_settings(settings, replace(request, seconds=left))
    numbers = {"judge_order": judge.trial.order, "judge_refinements": judge.trial.level}
    return Findings(points, notes=list(_notes(setup, trials, judge, errors)), numbers=numbers)


AXIS = Axis(
    name="reference",
    title="Finite elements of the reference",
    error="distance from the finest elements over the displacement",
    time="one load case of the reference",
    missing=_missing,
    measure=_measure,
    shown=("unknowns", "observed_order"),
)


def _setting(setup: Setup, judge: Judge, trial: Trial, errors: _Errors) -> Setting:
    stated, table = stated_table(setup).model_dump(), trial.table.model_dump()
    said = {key: value for key, value in table.items() if key in ("order", "refinements") or value != stated[key]}
    numbers = {
        "unknowns": float(trial.unknowns),
        "cells": float(cell_count(setup, trial.level)),
        "theoretical_order": THEORY[trial.order],
    }
    observed = _observed(errors, trial.order, trial.level)
    if observed is not None:
        numbers["observed_order"] = observed.value
    series, name = key_of(setup, trial.order, trial.level)
    return Setting(
        series=series,
        name=name,
        run=partial(deformed, setup, trial.table),
        judge=partial(errors_of, setup, judge, trial),
        solves=len(setup.cases),
        states={f"reference.{key}": value for key, value in said.items()},
        is_stated=table == stated,
        numbers=numbers,
        why=lambda answers: trial.why,
    )


def _observed(errors: _Errors, order: int, level: int) -> Interval | None:
    """The order of convergence between a mesh and the one before it, over the load cases."""
    if (order, level - 1) not in errors or (order, level) not in errors:
        return None
    coarse, fine = errors[order, level - 1], errors[order, level]
    is_told = np.isfinite(coarse) & np.isfinite(fine) & (np.minimum(coarse, fine) > ROUNDING)
    return Interval.of(np.log2(coarse[is_told] / fine[is_told])) if is_told.any() else None


def _notes(setup: Setup, trials: Sequence[Trial], judge: Judge, errors: _Errors) -> Iterator[str]:
    series, name = key_of(setup, judge.trial.order, judge.trial.level)
    extrapolated = f", in {judge.extrapolated} of {len(judge.positions)} load cases extrapolated from three meshes"
    yield (
        f"Errors are distances from elements of {series} on {name}, with {judge.trial.unknowns:,} unknowns"
        f"{extrapolated if judge.extrapolated else ''}."
    )
    yield "On all meshes nodal forces are the tractions, or inside the forces by volume, that they are on the lattice."
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
    points = max(refinement_of(setup, 0, 1).count_points(case.supports) for case in setup.cases)
    if points:
        yield (
            f"Up to {points} held nodes in a load case fill no side of a cell and stay points, which give way the more "
            "the finer the elements are: unless they carry nothing, there is no limit to converge to."
        )
    if (stated_table(setup).order, stated_table(setup).refinements) not in errors:
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


def _doubts(setup: Setup, trials: Sequence[Trial], judge: Judge) -> list[float]:
    """How far from the judge the limits of the first-order elements are, as errors."""
    limits = limits_of(trials, 1) if judge.trial.order == 2 else []
    pairs = zip(limits, judge.positions, strict=True) if limits else []
    return [error_of(setup, limit, known) for limit, known in pairs if limit is not None]


def _nothing_judges(trials: Sequence[Trial]) -> str:
    first = trials[0]
    if not first.is_complete:
        return f"No elements answer every load case: {first.why}"
    if len(trials) > 1:
        return f"Finer elements than those of the lattice do not answer every load case: {trials[1].why}"
    return (
        f"With {first.unknowns:,} unknowns on the lattice itself, elements of second order would be too many for the "
        "time that is given, so that nothing judges those of the lattice."
    )
