"""The step of an identified model in real time: one body that moves, under one load case.

The step in time. Real time has a clock, and a body its own: a step is useful where it resolves the slowest swing that
one sees. A scene in motion states masses and step. For another one the body gets a density of 1, and steps of a
twentieth of its slowest period, so that the density drops out: two bodies of one shape that differ in density and step
alone make the same numbers. The period is Rayleigh's (1877): of the deflection under the body's own weight, by springs
alone at small displacements. Dashpots along the springs take 5 % of the critical damping of that swing.

What is timed. A step is implicit, from the state before. A motion of many steps is one call of the compiled loop, so
that Python and the plan of the factors have no part in it; its time over its steps is a step's. Small systems go
through lanes, which solve eight equilibria for about the price of one, and a single body fills one of the eight. What
counts is the processor's time: real time gives a body a core to itself, and a machine that is shared with others, as
while this is measured, would make models look slower than they are.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from springopt.checks import Floats
from springopt.effects.damping import Damping
from springopt.effects.effect import Effect
from springopt.effects.inertia import Inertia
from springopt.forward.batch import Group
from springopt.forward.motion.follow import Motions
from springopt.forward.motion.stepping import Stepping
from springopt.forward.status import has_equilibrium
from springopt.lattice import SpringLattice
from springopt.load_case import LoadCase
from springopt.model import Model
from springopt.scene import Scene
from springopt.tradeoff.clock import time_all
from springopt.tradeoff.interval import Interval

STEPS_A_PERIOD = 20
DAMPING = 0.05  # of the critical one, in the slowest swing
MOST_STEPS = 200  # of a motion that is timed: ten periods, in which it has not come to rest
LEAST_STEPS = STEPS_A_PERIOD
ENOUGH = 0.1  # seconds that a motion takes, if it may be as short as that


@dataclass(frozen=True)
class Clockwork:
    """What a body that moves has beside its springs, and the steps it takes."""

    effects: tuple[Effect, ...]  #: those of the scene, and what they lack for motion
    stepping: Stepping
    said: str  #: a sentence on the step


@dataclass(frozen=True, eq=False)
class Moving:
    """One body under one load case, for so many steps."""

    model: Model
    row: Floats  #: shape (s + f,)
    case: LoadCase
    steps: int
    tolerance: float

    @cached_property
    def groups(self) -> tuple[Group, ...]:
        assert self.model.stepping is not None
        return self.model.groups([replace(self.case, times=np.array([self.steps * self.model.stepping.step]))])

    def run(self) -> Motions:
        motions = self.model.find(self.groups, self.row[None], self.tolerance)
        assert isinstance(motions, Motions)
        return motions


@dataclass(frozen=True)
class Step:
    """What one step takes."""

    seconds: Interval  #: of the processor: what it takes with a core to itself, which real time has to give it
    wall: Interval  #: seconds on the wall, beside whatever else the machine did
    steps: int  #: that were timed at once


def clockwork(scene: Scene, model: Model, row: Floats, case: LoadCase) -> Clockwork | None:
    """For all bodies of a scene, from one of them (s + f,); None where springs alone do not hold that one.

    Args:
        scene: whose effects and step hold as far as they are stated.
        model, row: an identified model of it.
        case: where it is held.
    """
    effects = [effect.build() for effect in scene.effects]
    if not any(term.has_masses for term in model.terms.terms):
        effects.append(Inertia(mass=1.0) if model.lattice.cells is None else Inertia(density=1.0))
    weighed = replace(model, effects=effects)
    period = slowest_period(weighed, row, case)
    if scene.stepping is not None:
        return Clockwork(tuple(effects), scene.stepping.build(), "A step in real time is as long as the scene states.")
    if period is None:
        return None
    if not any(effect.name == Damping.name for effect in effects):
        effects.append(Damping(springs=DAMPING * period / np.pi))
    said = f"A step in real time is 1/{STEPS_A_PERIOD} of the slowest period, whatever the density."
    return Clockwork(tuple(effects), Stepping(period / STEPS_A_PERIOD), said)


def slowest_period(model: Model, row: Floats, case: LoadCase) -> float | None:
    """By Rayleigh's quotient of the deflections under weights along each axis [time]; None where nothing holds it."""
    lattice, springs = model.lattice, model.lattice.spring_count
    masses = model.terms.masses(model.terms.rows(row[None])[:, springs:])[0]
    weights = [_weight(lattice, masses, case, axis) for axis in range(lattice.dimension)]
    solution = Model(lattice, kinematics="linear").solve(row[:springs], weights)
    if not all(status.has_equilibrium for status in solution.status):
        return None
    squares = [
        np.vdot(weight.forces, u) / np.vdot(masses[:, None] * u, u)
        for weight, u in zip(weights, solution.displacements, strict=True)
        if u.any()
    ]
    return float(2 * np.pi / np.sqrt(min(squares))) if squares else None


def moving(clock: Clockwork, model: Model, row: Floats, case: LoadCase, tolerance: float) -> Moving:
    """An identified model in motion, with exact kinematics."""
    engine = model.engine if model.kinematics == "exact" else None
    body = Model(model.lattice, clock.effects, engine=engine, fitted=model.fitted, stepping=clock.stepping)
    return Moving(body, row, case, LEAST_STEPS, tolerance)


def time_step(body: Moving, seconds: float) -> Step | None:
    """The step of a body, measured for so many seconds, and once at least; None where its motion breaks off."""
    body.run()  # plans are made, and kernels compiled
    begun = time.perf_counter()
    motions = body.run()
    few = time.perf_counter() - begun
    steps = int(np.clip(LEAST_STEPS * ENOUGH / few, LEAST_STEPS, MOST_STEPS))
    if steps > body.steps:
        body = replace(body, steps=steps)
        motions = body.run()
    if not has_equilibrium(motions.codes).all():
        return None
    (timing,) = time_all([("", body.run)], seconds)
    taken = int(motions.steps.max())
    return Step(Interval.of(timing.processor / taken), Interval.of(timing.wall / taken), taken)


def _weight(lattice: SpringLattice, masses: Floats, case: LoadCase, axis: int) -> LoadCase:
    forces = np.zeros(lattice.nodes.shape)
    forces[:, axis] = masses
    return LoadCase("weight", case.supports, np.where(case.supports, 0.0, forces))
