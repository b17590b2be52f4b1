"""Checks of rigid motions, and of dissipations."""

from __future__ import annotations

import numpy as np

from springopt.checks import Floats
from springopt.effects.effect import Effect
from springopt.lattice import SpringLattice
from springopt.testing.effect_trial import (
    EffectSubject,
    bodies_of,
    constant_forces,
    dissipations,
    kernels,
)
from springopt.testing.effect_verdicts import (
    LANES,
    ROUNDING,
    largest,
    made_ready,
    require_blocks,
)
from springopt.testing.verdict import require


def check_rigid_motions_cost_nothing(effect: EffectSubject, lattice: SpringLattice | None = None) -> None:
    """Where it claims to be invariant, net force and torque are zero, and rigid motions dissipate nothing."""
    ready = made_ready(effect)
    for body in bodies_of(ready, lattice):
        forces = constant_forces(ready, body.lattice)
        if forces is not None:
            _require_balance(ready, f"the constant force of {ready.name} on {body.title}", body.lattice.nodes, forces)
    for trial in kernels(ready, lattice):
        answer = trial.answers(trial.states)
        for lane in LANES:
            positions = trial.lattice.nodes + trial.states.displacements[lane].reshape(trial.lattice.nodes.shape)
            _require_balance(ready, trial.what, positions, answer.forces[lane].reshape(positions.shape))
    for trial in dissipations(ready, lattice):
        for lane in LANES:
            positions = trial.lattice.nodes + trial.states.displacements[lane].reshape(trial.lattice.nodes.shape)
            usual = largest(trial.at(lane).energy)
            for claim, velocity in _rigid_motions(ready, positions):
                power = largest(trial.at(lane, velocities=velocity.reshape(1, -1)).energy)
                require(
                    power <= ROUNDING * usual,
                    f"{trial.what} dissipates in a rigid motion; say {claim} = False, or make it so.",
                )


def check_dissipation_takes_power(effect: EffectSubject, lattice: SpringLattice | None = None) -> None:
    """The power of a dissipation is velocity times force, is never negative, and zero where nothing moves."""
    ready = made_ready(effect)
    for trial in dissipations(ready, lattice):
        answer = trial.answers(trial.states)
        work = trial.states.velocities * answer.forces
        power = work.sum(axis=1)
        still = trial.answers(trial.states._replace(velocities=np.zeros_like(trial.states.velocities)))
        require(
            bool(np.all(np.abs(answer.energy - power) <= ROUNDING * np.abs(work).sum(axis=1))),
            f"{trial.what} adds another power than that of its forces; add velocity times force, once.",
        )
        require(
            bool(np.all(power >= -ROUNDING * np.abs(work).sum(axis=1)))
            and not still.forces.any()
            and not still.energy.any(),
            f"{trial.what} gives power, or acts where nothing moves; its forces act against the motion, and are added "
            "with the sign of the velocity, as internal forces are.",
        )


def check_dissipation_blocks_are_derivatives(effect: EffectSubject, lattice: SpringLattice | None = None) -> None:
    """The blocks of a dissipation are the derivatives of its forces by the velocities."""
    ready = made_ready(effect)
    for trial in dissipations(ready, lattice):
        require_blocks(trial, "velocities")


def _require_balance(effect: Effect, what: str, positions: Floats, forces: Floats) -> None:
    net = largest(forces.sum(axis=0))
    require(
        not effect.is_translation_invariant or net <= ROUNDING * np.abs(forces).sum(),
        f"{what} has a net force, so that moving the body costs energy; say is_translation_invariant = False.",
    )
    torques = positions[:, :, None] * forces[:, None, :]
    torques = torques - torques.swapaxes(1, 2)
    require(
        not effect.is_rotation_invariant or largest(torques.sum(axis=0)) <= ROUNDING * np.abs(torques).sum(),
        f"{what} has a net torque, so that turning the body costs energy; say is_rotation_invariant = False.",
    )


def _rigid_motions(effect: Effect, positions: Floats) -> list[tuple[str, Floats]]:
    """The velocities that cost nothing by its claims, each with the claim."""
    d, motions = positions.shape[1], []
    if effect.is_translation_invariant:
        motions += [("is_translation_invariant", np.broadcast_to(axis, positions.shape)) for axis in np.eye(d)]
    if effect.is_rotation_invariant:
        for a, b in [(0, 1), (1, 2), (0, 2)][: d * (d - 1) // 2]:
            velocity = np.zeros_like(positions)
            velocity[:, a], velocity[:, b] = -positions[:, b], positions[:, a]
            motions.append(("is_rotation_invariant", velocity))
    return motions
