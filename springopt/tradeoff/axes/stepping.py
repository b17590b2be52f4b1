"""How exactly motion is followed in time: the integrator and its step, or the error that a step may make.

Judged by SciPy's Runge-Kutta method of eighth order, see `independent.motion`; the step at which explicit stepping
becomes unstable is marked beside the implicit ones, which go on.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from springopt.analysis.point import choose_point
from springopt.checks import Floats
from springopt.effects.lanes import LANE_COUNT
from springopt.errors import UserError
from springopt.forward.motion.follow import Motions
from springopt.forward.motion.stepping import ENERGY_MOMENTUM, INTEGRATORS, Stepping
from springopt.forward.status import STATUSES, has_equilibrium
from springopt.load_case import LoadCase
from springopt.scene import Scene, Setup
from springopt.scene.build import build_model
from springopt.tradeoff.errors import errors_of_cases
from springopt.tradeoff.independent.motion import KnownMotion, known_motion, massless_node
from springopt.tradeoff.independent.stability_limit import StabilityLimit, stability_limit
from springopt.tradeoff.independent.system import System
from springopt.tradeoff.point import Axis, Findings, Point, Request, Setting, measure_settings

#: Steps as multiples of the scene's own; errors that a step may make, with the longest of these steps.
MULTIPLES = tuple(2.0**power for power in range(2, -6, -1))
STEP_ERRORS = tuple(float(f"1e-{digits}") for digits in range(2, 8))
ADAPTIVE = f"{ENERGY_MOMENTUM}, adaptive"
ORDER = 2  # of both integrators
#: Calls of a setting that there should be time for; the share of the seconds that is left to the clock.
CALLS, LEAST_SHARE = 12, 0.5
LARGEST = 3_000  # degrees of freedom: beyond, SciPy takes minutes for a motion
#: Errors this much above the doubt in what is known tell the order, from steps this close to the finest one.
CLEAR, FINEST = 100.0, 4.0
DAMPED = 0.01  # a damping ratio that changes the limit of explicit stepping


def _missing(scene: Scene) -> str | None:
    if scene.load_cases.times is None:
        return "its load cases have no times"
    lattice = scene.lattice.build()
    if lattice.nodes.size > LARGEST:
        return f"its motions are known up to {LARGEST:,} degrees of freedom, not {lattice.nodes.size:,}"
    terms = build_model(scene, lattice).terms
    masses = terms.masses(terms.defaults)
    for case in scene.load_cases.build(lattice):
        node = massless_node(masses, case)
        if node is not None:
            return f"node {node} moves in load case {case.name!r} and has no mass, which explicit methods can't follow"
    return None


@dataclass(frozen=True, eq=False)
class _Motions:
    """What every setting follows, and the motions that are known."""

    setup: Setup
    candidates: Floats  #: one and the same, as often as fills the lanes, shape (m, s + f)
    known: Sequence[KnownMotion]  #: of each load case

    @property
    def cases(self) -> list[LoadCase]:
        return self.setup.cases

    def setting(self, series: str, name: str, stepping: Stepping) -> Setting:
        model = replace(self.setup.model, stepping=stepping)
        states: dict[str, Any] = {"stepping.integrator": stepping.integrator, "stepping.step": stepping.step}
        if stepping.step_error is not None:
            states["stepping.step_error"] = stepping.step_error
        return Setting(
            series=series,
            name=name,
            run=partial(model.find, model.groups(self.cases), self.candidates, self.setup.objective.tolerance),
            judge=self.judge,
            solves=len(self.candidates) * len(self.cases),
            states=states,
            is_stated=stepping == self.setup.model.stepping,
            count=lambda answer: {"steps": float(np.median(answer.steps[0]))},
            why=self.why,
        )

    def judge(self, answer: Motions) -> Floats:
        """Of every load case, over all its times; inf where the motion breaks off."""
        nodes = self.setup.lattice.nodes
        u = answer.displacements[0].reshape(*answer.displacements.shape[1:3], *nodes.shape)
        known = np.stack([motion.displacements.reshape(u.shape[1:]) for motion in self.known])
        errors = errors_of_cases(nodes + u, nodes + known, nodes)
        errors[~has_equilibrium(answer.codes[0])] = np.inf
        return errors

    def why(self, answer: Motions) -> str:
        codes = answer.codes[0]
        counts = Counter(str(STATUSES[code]) for code in codes[~has_equilibrium(codes)])
        return ", ".join(f"{status} in {count} of {len(codes)} motions" for status, count in counts.items())


def _measure(setup: Setup, request: Request) -> Findings:
    end = time.perf_counter() + request.seconds
    point = choose_point(setup)
    candidate = setup.encoding.decode(point.numbers)
    system = System.of(setup.model, candidate, np.float64)
    try:
        known = [known_motion(system, case) for case in setup.cases]
    except UserError as error:
        return Findings([], notes=[f"Nothing is measured: {error}"])
    copies = -(-LANE_COUNT // len(setup.cases))
    motions = _Motions(setup, np.tile(candidate, (copies, 1)), known)
    settings, left_out = _settings(motions, request)
    left = max(end - time.perf_counter(), LEAST_SHARE * request.seconds)
    points = measure_settings(settings, replace(request, seconds=left))
    limits = [stability_limit(system, case) for case in setup.cases]
    tightest = int(np.argmin([limit.step for limit in limits]))
    marks, said = _limit_marked(setup, points, limits[tightest], setup.cases[tightest])
    doubt = max(motion.doubt for motion in motions.known)
    notes = [
        f"Followed is one candidate, {point.said}, under all load cases ({len(setup.cases)}), "
        f"{copies} times over to fill the lanes.",
        f"Errors are measured against SciPy's DOP853, with forces apart from the forward solve's; a looser run of it "
        f"comes within {doubt:.0e} of the displacements.",
        *left_out,
        *said,
        *_orders(setup, points, doubt),
    ]
    return Findings(points, marks=marks, notes=notes)


def _settings(motions: _Motions, request: Request) -> tuple[list[Setting], list[str]]:
    """(the settings that there is time for, from long steps to short ones; what is said of the others)."""
    own = motions.setup.model.stepping
    assert own is not None  # a scene with times has it
    fixed = [Stepping(step) for step in _steps(own.step, motions.cases)]
    longest = own.step * MULTIPLES[0]
    ladders = {
        **{integrator: [replace(each, integrator=integrator) for each in fixed] for integrator in INTEGRATORS},
        ADAPTIVE: [Stepping(longest, step_error=allowed) for allowed in STEP_ERRORS],
    }
    if own.step_error is not None:
        ladders[f"{own.integrator}, as stated"] = [own]
    settings: list[Setting] = []
    notes = []
    for series, ladder in ladders.items():
        offered = [motions.setting(series, _name(each, motions.cases), each) for each in ladder]
        affordable = offered if request.only else _affordable(offered, request.seconds / len(ladders))
        settings += affordable
        if len(affordable) < len(offered):
            notes.append(
                f"Of {series} what is beyond {affordable[-1].name} is left out: it takes more than there is time for."
            )
    return settings, notes


def _steps(own: float, cases: Sequence[LoadCase]) -> list[float]:
    """Multiples of the scene's own step; of those that end on the times by equally many steps the last alone."""
    by_count = {_count(own * multiple, cases): own * multiple for multiple in MULTIPLES[: MULTIPLES.index(1.0)]}
    by_count |= {_count(own * multiple, cases): own * multiple for multiple in MULTIPLES[MULTIPLES.index(1.0) :]}
    return sorted(by_count.values(), reverse=True)


def _count(step: float, cases: Sequence[LoadCase]) -> int:
    """How many steps, no longer than this and equal between two times, the load cases take."""
    return sum(len(_taken(step, case)) for case in cases)


def _taken(step: float, case: LoadCase) -> Floats:
    """The steps of one motion, as `forward.motion.steps` takes them: equal between two times, on which they end."""
    assert case.times is not None  # it is a motion
    gaps = np.diff(case.times, prepend=0.0)
    counts = np.maximum(np.ceil(gaps / step - 1e-9), 1.0).astype(np.int64)
    return np.repeat(gaps / counts, counts)


def _name(stepping: Stepping, cases: Sequence[LoadCase]) -> str:
    """As in "step 0.4", or where steps are shorter, because they end on the times, "step 0.8 (0.5 taken)"."""
    if stepping.step_error is not None:
        return f"step error {stepping.step_error:.0e}".replace("e-0", "e-")
    taken = _longest(stepping.step, cases)
    return f"step {stepping.step:.4g}" + (f" ({taken:.3g} taken)" if taken < 0.999 * stepping.step else "")


def _affordable(offered: Sequence[Setting], seconds: float) -> list[Setting]:
    """Those that can be called often enough, up to the first that can't; the first one in any case."""
    offered[0].run()  # may compile
    spent = 0.0
    settings: list[Setting] = []
    for setting in offered:
        begin = time.perf_counter()
        setting.run()
        spent += CALLS * (time.perf_counter() - begin)
        if settings and spent > seconds:
            break
        settings.append(setting)
    return settings


def _limit_marked(
    setup: Setup, points: Sequence[Point], limit: StabilityLimit, case: LoadCase
) -> tuple[dict[str, float], list[str]]:
    """(what a step at the limit of explicit stepping costs implicitly [s], what is said of the limit)."""
    if not np.isfinite(limit.step):
        return {}, ["Nothing vibrates where the motions begin, so that no step is too long for explicit stepping."]
    said = (
        f"Explicit stepping (central differences) is unstable above a step of {limit.step:.3g}: the fastest vibration "
        f"at the beginning of {case.name!r} has the angular frequency {limit.frequency:.3g} and the damping ratio "
        f"{limit.damping_ratio:.2g}"
    )
    said += f" (without damping the limit would be {limit.undamped:.3g})." if limit.damping_ratio > DAMPED else "."
    cases = setup.cases
    longest = {
        point: _longest(point.states["stepping.step"], cases) for point in points if point.series == ENERGY_MOMENTUM
    }
    beyond = [f"{step:.3g}" for step in longest.values() if step > limit.step]
    if beyond:
        said += f" Implicit stepping goes on beyond it, here with steps of {', '.join(beyond)}."
    steps, seconds = (
        np.array(column) for column in ([*longest.values()], [point.processor_seconds.value for point in longest])
    )
    order = np.argsort(steps)
    if not len(steps) or not steps.min() <= limit.step <= steps.max():
        return {}, [f"{said} No setting is near it, so that it is not marked in the figure."]
    cost = float(np.exp(np.interp(np.log(limit.step), np.log(steps[order]), np.log(seconds[order]))))
    return {f"explicit limit: step {limit.step:.2g}": cost}, [said]


def _longest(step: float, cases: Sequence[LoadCase]) -> float:
    """The longest that is taken in any load case, where no step may be longer than this."""
    return max(float(_taken(step, case).max()) for case in cases)


def _orders(setup: Setup, points: Sequence[Point], doubt: float) -> list[str]:
    """The order that each integrator shows where its steps are fine, and its errors clear of the doubt."""
    said = []
    for integrator in INTEGRATORS:
        own = [p for p in points if p.series == integrator and p.is_good and p.errors.min() > CLEAR * doubt]
        steps = np.array([_longest(point.states["stepping.step"], setup.cases) for point in own])
        is_fine = steps <= FINEST * steps.min(initial=np.inf)
        if np.count_nonzero(is_fine) < 2:
            continue
        errors = np.array([np.exp(np.log(point.errors).mean()) for point in own])
        order = np.polyfit(np.log(steps[is_fine]), np.log(errors[is_fine]), 1)[0]
        said.append(
            f"The observed order of {integrator} is {order:.2f}, at steps of {steps[is_fine].max():.3g} to "
            f"{steps.min():.3g}; in theory it is {ORDER}."
        )
    return said


AXIS = Axis(
    name="stepping",
    title="Integrator and time step of motion",
    error="distance from the motion / displacement",
    time="one motion",
    missing=_missing,
    measure=_measure,
    shown=("steps",),
)
