"""What the axis finds: variations identified, solved and set in motion, one after the other."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from springopt.analysis.fit import warm_up
from springopt.scene import Scene, Setup
from springopt.scene.lattice_tables import GridTable
from springopt.tradeoff.axes.model.identification import SPARSITY, Identified, identify, sparser
from springopt.tradeoff.axes.model.largest import RATES, Sizes, largest_that_keeps, stage
from springopt.tradeoff.axes.model.real_time import Clockwork, Step, clockwork, moving, time_step
from springopt.tradeoff.axes.model.resampling import why_fixed
from springopt.tradeoff.axes.model.resolution import resolutions
from springopt.tradeoff.axes.model.running import Running
from springopt.tradeoff.axes.model.variation import Variation, encodings, neighbourhoods
from springopt.tradeoff.errors import say_least
from springopt.tradeoff.point import Findings, Point, Request, Setting, measure_settings

#: When the parts of the work end, as shares of the time that is asked for: fits, the path to fewer springs, forward
#: solves, steps in real time; the rest is for the largest models.
FITTED, SPARSE, SOLVED, STEPPED = 0.38, 0.48, 0.6, 0.68
LEAST_GROWN = 0.15  # of the time, for these, where what came before took longer than it should
FREE = ("encodings", "free")
HOMOGENEOUS = ("encodings", "homogeneous")
SMALL = 1000  # nodes that any engine moves in no time
NEAR = 10.0  # a rate is marked where it is within this factor of the times that were found


def why_missing(scene: Scene) -> str | None:
    """Every scene has a model."""
    return None


def measure(setup: Setup, request: Request) -> Findings:
    """Points of all variations, and how large a model in real time may be.

    What is compiled for the first time on a machine comes before the clock that `request.seconds` are read from.
    """
    offered = [find(setup) for find in (encodings, neighbourhoods, resolutions)]
    notes = [note for variations in offered for note in variations.notes]
    wanted = _wanted([each for variations in offered for each in variations.of], request)
    _warm_up(setup, wanted)
    begun = time.perf_counter()
    found = identify(wanted, request, begun + FITTED * request.seconds)
    if len(found) < len(wanted):
        left_out = "; ".join(f"{each.series}, {each.name}" for each in wanted[len(found) :])
        notes.append(f"The time was up before these were identified, give more of it: {left_out}.")
    by_name = {(each.variation.series, each.variation.name): each for each in found}
    if FREE in by_name:
        fewer, said = sparser(by_name[FREE], request, begun + SPARSE * request.seconds)
        found, notes = found + fewer, notes + said
    found = [each for each in found if request.wants(each.variation.series, each.variation.name)]
    if not found:
        return Findings([], notes=notes)
    notes += _of_fits(setup, found)
    running = [Running.of(each.setup, each.row) for each in found]
    clock, said = _clock(setup, found, running)
    steps = _steps(clock, running, request, begun + request.seconds)
    if clock is not None and None in steps:
        notes.append("Some steps in real time are not there: the motion breaks off, or the time was up.")
    points = _points(found, running, steps, request)
    notes += say_least((point.errors for point in points), setup.objective.tolerance)
    numbers: dict[str, object] = {}
    if clock is not None and not request.only:
        seconds = max(begun + request.seconds - time.perf_counter(), LEAST_GROWN * request.seconds)
        kept, numbers = _rates(setup, by_name.get(HOMOGENEOUS), clock, points, replace(request, seconds=seconds))
        said += kept
    return Findings(points, marks=_marks(points), notes=notes + said, numbers=numbers)


def _wanted(variations: Sequence[Variation], request: Request) -> list[Variation]:
    """Those that are asked for, and the free fit where its path is."""
    needs_free = any(series == SPARSITY for series, _ in request.only)
    return [
        each
        for each in variations
        if request.wants(each.series, each.name) or (needs_free and (each.series, each.name) == FREE)
    ]


def _warm_up(setup: Setup, wanted: Sequence[Variation]) -> None:
    """What is compiled for fits, and for motion in small systems and in large ones."""
    warm_up([each.setup for each in wanted])
    row = setup.encoding.decode(setup.encoding.upper)
    clock = clockwork(setup.scene, setup.model, row, setup.cases[0])
    engines = ("lanes", "sparse") if setup.lattice.node_count <= SMALL else (None,)
    for engine in engines:
        if clock is None:
            return
        model = replace(setup.model, kinematics="exact", engine=engine)
        moving(clock, model, row, setup.cases[0], setup.objective.tolerance).run()


def _of_fits(setup: Setup, found: Sequence[Identified]) -> list[str]:
    """What a reader should know of how stiffness was found, and of what judges it."""
    methods = sorted({each.method for each in found})
    notes = [f"Stiffness was identified by {', '.join(methods)}, within the time that there was."]
    if all(case.role == "train" for case in setup.cases):
        notes.append("The scene has no test load cases: errors are those of the load cases that it learns from.")
    cut = [each.variation for each in found if each.is_cut and each.variation.series != SPARSITY]
    if cut:
        names = "; ".join(f"{variation.series}, {variation.name}" for variation in cut)
        notes.append(f"The time ended these fits, which more of it may improve: {names}.")
    return notes


def _points(
    found: Sequence[Identified], running: Sequence[Running], steps: Sequence[Step | None], request: Request
) -> list[Point]:
    settings = [_setting(*each) for each in zip(found, running, steps, strict=True)]
    return measure_settings(settings, replace(request, seconds=(SOLVED - SPARSE) * request.seconds))


def _setting(one: Identified, body: Running, step: Step | None) -> Setting:
    is_test, answers = body.is_test(), body.solve()
    tests = np.array([case.role == "test" for case in one.setup.cases])
    errors, misfits = body.errors(answers), body.misfits(answers)
    numbers = {
        "nodes": one.setup.lattice.node_count,
        "springs": body.spring_count,
        "unknowns": one.unknowns,
        "training_misfit": float(misfits[~tests].mean()),  # of a load case, as those of the tests are
        "training_error": float(errors[~tests].mean()),
        "fit_seconds": one.seconds,
        "fit_is_cut": float(one.is_cut),
    }
    if tests.any():
        numbers |= {"test_misfit": float(misfits[tests].mean())}
    if step is not None:
        numbers |= {"step_seconds": step.seconds.value, "steps_per_second": 1 / step.seconds.value}
        numbers |= {"step_wall_seconds": step.wall.value}
    return Setting(
        series=one.variation.series,
        name=one.variation.name,
        run=body.solve,
        # The forward solve can't tell less from zero; of mass-spring references it is the same one.
        judge=lambda found: np.maximum(body.errors(found)[is_test], one.setup.objective.tolerance),
        solves=len(one.setup.cases),
        states=one.variation.states,
        is_stated=one.variation.is_stated,
        is_apart=one.variation.is_apart,
        numbers=numbers,
        second_time=None if step is None else step.seconds,
        why=body.why,
    )


def _clock(setup: Setup, found: Sequence[Identified], running: Sequence[Running]) -> tuple[Clockwork | None, list[str]]:
    """The step of all bodies, by the first one that is held by its springs; and sentences on it."""
    for each, body in zip(found, running, strict=True):
        clock = clockwork(setup.scene, body.model, body.row, each.setup.cases[0])
        if clock is not None:
            said = [clock.said]
            if setup.scene.kinematics == "linear":
                said.append("In real time kinematics are exact, though the scene's displacements are small.")
            return clock, said
    return None, ["No step in real time was measured, as no model is held by its springs alone."]


def _steps(clock: Clockwork | None, running: Sequence[Running], request: Request, until: float) -> list[Step | None]:
    """The step of each body, None where its motion breaks off, or for want of a clock or of time."""
    if clock is None:
        return [None] * len(running)
    seconds = (STEPPED - SOLVED) * request.seconds / len(running)
    steps = []
    for done, body in enumerate(running):
        moved = moving(clock, body.model, body.row, body.setup.cases[0], body.setup.objective.tolerance)
        steps.append(time_step(moved, seconds) if time.perf_counter() < until or not done else None)
        if request.progress:
            request.progress(done + 1, len(running), "models set in motion")
    return steps


def _rates(
    setup: Setup, homogeneous: Identified | None, clock: Clockwork, points: Sequence[Point], request: Request
) -> tuple[list[str], dict[str, object]]:
    """Sentences and numbers on how large a model may be, or, where it can't have other nodes, whether this one may."""
    why = why_fixed(setup.scene)
    growing = stage(setup.scene) if why is None else None
    if growing is None or homogeneous is None:
        why = why or "no load case is held by sides alone"
        return _this_one(points, why), {}
    assert isinstance(setup.scene.lattice, GridTable)
    sizes = Sizes(growing, homogeneous, clock)
    until = time.perf_counter() + request.seconds
    kept = []
    for done, rate in enumerate(RATES):
        if request.progress:
            request.progress(done, len(RATES), f"the largest model that keeps {rate}")
        kept.append(largest_that_keeps(rate, sizes, (until - time.perf_counter()) / (len(RATES) - done)))
    lanes = (
        "Steps are those of one body with a core to itself; it fills one of the eight lanes in which small systems are "
        "solved, and eight would cost about as much."
    )
    numbers: dict[str, object] = {
        "real_time": {each.rate: each.numbers() for each in kept},
        "step_seconds_by_springs": {size.springs: size.seconds for _, size in sorted(sizes.timed.items())},
    }
    return [lanes, *(each.sentence for each in kept)], numbers


def _this_one(points: Sequence[Point], why: str) -> list[str]:
    own = next((point for point in points if point.is_stated and "step_seconds" in point.numbers), None)
    if own is None:
        return [f"How large a model in real time may be was not measured, because {why}."]
    step = own.numbers["step_seconds"]
    said = [f"{rate} is {'kept' if step <= limit else 'not kept'}" for rate, limit in RATES.items()]
    kept = " and ".join(said)
    return [f"Larger models were not tried, because {why}; by this one {kept}: a step takes {1e3 * step:.3g} ms."]


def _marks(points: Sequence[Point]) -> dict[str, float]:
    """The rates that are near enough to the steps that were found to be seen beside them."""
    steps = [point.second_time.value for point in points if point.second_time is not None]
    return {rate: limit for rate, limit in RATES.items() if steps and min(steps) / NEAR <= limit <= NEAR * max(steps)}
