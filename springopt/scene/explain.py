"""What the forward solve makes of a scene: its effects, and for each set of supports the engine and why."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from springopt.effects.effect import Effect, Kernel
from springopt.forward.choose import Choice
from springopt.forward.terms import Term
from springopt.load_case import LoadCase
from springopt.model import Model
from springopt.scene.build import build_model
from springopt.scene.schema import Scene

#: The kernels that an engine's search consists of, at rest and in motion.
LOOPS = {
    "lanes": "find_equilibria",
    "sparse": "arrive, aim, depart",
    "iterative": "arrive, aim, depart",
    "linear": "evaluate_forces",
    "linear in lanes": "solve_eights",
}
LOOPS_IN_MOTION = {"lanes": "follow_motions"}


@dataclass(frozen=True)
class EffectNote:
    """What one effect brings to the solve."""

    name: str
    brings: str  #: what, and why so, in sentences
    kernels: list[str]  #: those that are called in the loop
    blocks: int  #: of the tangent that they add to
    parameters: dict[str, int]  #: what may be fitted, and how many numbers it has
    fitted: list[str]  #: in which candidates differ
    acts_on_reference: bool


@dataclass(frozen=True)
class SupportNote:
    """The load cases that share a set of supports, and how they are solved."""

    load_cases: list[str]
    engine: str
    solver: str
    unknowns: int
    half_bandwidth: int
    loop: str  #: the compiled loop that it is, by the name of its kernels
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
    springs = EffectNote(
        "springs",
        "Always there: force, tangent and energy are the engine's own.",
        kernels=["add_springs"],
        blocks=3 * lattice.spring_count,
        parameters={"stiffness": lattice.spring_count},
        fitted=["stiffness"],
        acts_on_reference=False,
    )
    supports = [
        SupportNote(
            load_cases=[cases[number].name for number in group.cases],
            engine=group.choice.engine,
            solver=group.choice.solver,
            unknowns=group.choice.unknowns,
            half_bandwidth=group.choice.half_bandwidth,
            loop=_loop(group.choice, is_motion),
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


def _loop(choice: Choice, is_motion: bool) -> str:
    if is_motion:
        return LOOPS_IN_MOTION.get(choice.engine, "motion.sparse")
    is_linear_in_lanes = (choice.engine, choice.solver) == ("linear", "lanes")
    return LOOPS["linear in lanes" if is_linear_in_lanes else choice.engine]


def _note(term: Term, model: Model, is_motion: bool) -> EffectNote:
    fitted, effect = model.terms.fitted_of(term), term.effect
    called = [(kind, kernel) for kind, kernel in _kernels(term) if is_motion or kind == "potential"]
    brought = [_say_kernel(kind, kernel) for kind, kernel in called]
    if term.constant_forces is not None:
        brought.append("A constant force: added to the load cases once, it costs nothing in the solve.")
    if effect.rest_lengths(model.lattice, fitted) is not None:
        brought.append("Rest lengths: data of the springs, which cost nothing in the solve.")
    if fitted and called and (effect.constant_forces(model.lattice) is not None or _is_data(effect, model)):
        brought.append(f"A kernel only because candidates differ in its {' and '.join(sorted(fitted))}.")
    if term.has_masses and is_motion:
        brought.append("Masses of the nodes: what moves has inertia.")
    if not brought:
        brought.append("Nothing at rest: it is felt in motion." if term.has_masses or term.dissipation else "Nothing.")
    if effect.acts_from_outside:
        brought.append("It acts from outside, so that a finite element reference obeys it too.")
    return EffectNote(
        term.name,
        " ".join(brought),
        kernels=[_name(kernel) for _, kernel in called],
        blocks=sum(len(kernel.pairs) for _, kernel in called),
        parameters={name: len(value) for name, value in effect.parameters(model.lattice).items()},
        fitted=sorted(fitted),
        acts_on_reference=effect.acts_from_outside,
    )


def _kernels(term: Term) -> list[tuple[str, Kernel]]:
    both = (("potential", term.potential), ("dissipation", term.dissipation))
    return [(kind, kernel) for kind, kernel in both if kernel is not None]


def _say_kernel(kind: str, kernel: Kernel) -> str:
    how = "its compiled kernel is" if kernel.is_compiled else "Python, which is slow, is"
    return f"A {kind}: {how} called at every evaluation, and adds to {len(kernel.pairs):,} blocks of the tangent."


def _is_data(effect: Effect, model: Model) -> bool:
    return effect.rest_lengths(model.lattice) is not None


def _name(kernel: Kernel) -> str:
    return str(getattr(kernel.function, "__name__", "evaluate"))


def _motion(model: Model, cases: Sequence[LoadCase]) -> MotionNote | None:
    stepping, times = model.stepping, cases[0].times
    if stepping is None or times is None:
        return None
    gaps = np.diff(times, prepend=0.0)
    # As the forward solve divides them, rounding off: equal steps between two times.
    steps = None if stepping.step_error is not None else int(np.ceil(gaps / stepping.step - 1e-9).sum())
    return MotionNote(stepping.integrator, float(stepping.step), times.tolist(), steps)
