"""What the forward solve makes of a scene: its effects, and for each set of supports the engine and why."""

from __future__ import annotations

from dataclasses import dataclass

from springopt.effects.effect import Effect
from springopt.lattice import SpringLattice
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


def explain(scene: Scene) -> Explanation:
    """Effects, engines and reasons, without solving anything, the reference included."""
    lattice = scene.lattice.build()
    model, cases = build_model(scene, lattice), scene.load_cases.build(lattice)
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
        effects=[springs, *(_note(effect, lattice) for effect in model.effects)],
        supports=supports,
    )


def _note(effect: Effect, lattice: SpringLattice) -> EffectNote:
    brought = []
    if effect.constant_forces(lattice) is not None:
        brought.append("A constant force: added to the load cases once, it costs nothing in the solve.")
    if effect.potential(lattice) is not None:
        brought.append("A potential: its compiled kernel is called at every evaluation.")
    return EffectNote(type(effect).__name__.lower(), " ".join(brought) or "Nothing.")
