"""What the forward solve makes of a scene: its effects, and for each set of supports the engine and why."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from springopt.forward.terms import Term
from springopt.load_case import LoadCase
from springopt.model import Model
from springopt.scene.build import build_model
from springopt.scene.schema import Scene


@dataclass(frozen=True)
class EffectNote:
    """What one effect brings to the solve."""

    name: str
    brings: str  #: one sentence


@dataclass(frozen=True)
class SupportNote:
    """The load cases that share a set of supports, and how they are solved."""

    load_cases: list[str]
    engine: str
    solver: str
    unknowns: int
    half_bandwidth: int
    why: str  #: one sentence


@dataclass(frozen=True)
class MotionNote:
    """How load cases with times go on in time."""

    integrator: str
    step: float  #: the longest one
    times: list[float]
    steps: int | None  #: of each load case; None where they are as short as their error takes


@dataclass(frozen=True)
class ParameterNote:
    """A parameter of an effect that is found beside the stiffness."""

    name: str
    numbers: int
    lower: float
    upper: float


@dataclass(frozen=True)
class Explanation:
    """A scene as the forward solve sees it."""

    scene: str
    title: str
    kinematics: str
    dimension: int
    nodes: int
    springs: int
    effects: list[EffectNote]
    supports: list[SupportNote]
    motion: MotionNote | None  #: None of load cases at rest
    parameters: list[ParameterNote]  #: those that are fitted


def explain(scene: Scene) -> Explanation:
    """Effects, engines and reasons, without solving anything, the reference included."""
    lattice = scene.lattice.build()
    model, cases = build_model(scene, lattice), scene.load_cases.build(lattice)
    is_motion = cases[0].times is not None
    springs = EffectNote("springs", "Always there: force, tangent and energy are the engine's own.")
    supports = [
        SupportNote(
            load_cases=[cases[number].name for number in group.cases],
            engine=group.choice.engine,
            solver=group.choice.solver,
            unknowns=group.choice.unknowns,
            half_bandwidth=group.choice.half_bandwidth,
            why=group.choice.why,
        )
        for group in model.groups(cases)
    ]
    return Explanation(
        scene=scene.name,
        title=scene.title,
        kinematics=model.kinematics,
        dimension=lattice.dimension,
        nodes=lattice.node_count,
        springs=lattice.spring_count,
        effects=[springs, *(_note(term, model, is_motion) for term in model.terms.terms)],
        supports=supports,
        motion=_motion(model, cases),
        parameters=[
            ParameterNote(name, model.terms.count(name), table.lower, table.upper)
            for table in scene.encoding.parameters
            for name in table.name
        ],
    )


def _note(term: Term, model: Model, is_motion: bool) -> EffectNote:
    fitted = model.terms.fitted_of(term)
    brought = []
    if term.constant_forces is not None:
        brought.append("A constant force: added to the load cases once, it costs nothing in the solve.")
    if term.effect.rest_lengths(model.lattice, fitted) is not None:
        brought.append("Rest lengths: data, they cost nothing in the solve.")
    for kind, kernel in (("potential", term.potential), ("dissipation", term.dissipation)):
        if kernel is not None and (is_motion or kind == "potential"):
            called = "its compiled kernel" if kernel.is_compiled else "Python, which is slow,"
            brought.append(f"A {kind}: {called} is called at every evaluation.")
    if term.has_masses and is_motion:
        brought.append("Masses of the nodes: what moves has inertia.")
    if not brought:
        brought.append("Nothing at rest: it is felt in motion." if term.has_masses or term.dissipation else "Nothing.")
    return EffectNote(term.name, " ".join(brought))


def _motion(model: Model, cases: Sequence[LoadCase]) -> MotionNote | None:
    stepping, times = model.stepping, cases[0].times
    if stepping is None or times is None:
        return None
    gaps = np.diff(times, prepend=0.0)
    # As the forward solve divides them, rounding off: equal steps between two times.
    steps = None if stepping.step_error is not None else int(np.ceil(gaps / stepping.step - 1e-9).sum())
    return MotionNote(stepping.integrator, float(stepping.step), times.tolist(), steps)
