"""Checks of potentials: energy, forces and blocks agree, and what is claimed of them is so."""

from __future__ import annotations

import numpy as np

from springopt.checks import Floats
from springopt.effects.effect import Effect
from springopt.effects.probe import force_derivatives, pulls_of_law
from springopt.lattice import SpringLattice
from springopt.testing.differences import differences, worst
from springopt.testing.effect_trial import (
    EffectSubject,
    bodies_of,
    choices_to_fit,
    constant_forces,
    flat,
    lattice_with_its_rest_lengths,
    potentials,
    spring_forces,
)
from springopt.testing.effect_verdicts import (
    ACCURACY,
    LANES,
    ROUNDING,
    largest,
    made_ready,
    require_array,
    require_blocks,
)
from springopt.testing.kernel_calls import Failed, States, Stray, answers
from springopt.testing.verdict import NotJudged, require


def check_forces_are_the_energys_derivatives(effect: EffectSubject, lattice: SpringLattice | None = None) -> None:
    """The forces of a potential are the derivatives of its energy by the displacements."""
    ready = made_ready(effect)
    for trial in potentials(ready, lattice):
        for lane in LANES:
            answer = trial.at(lane)
            estimates = differences(
                lambda rows, trial=trial, lane=lane: trial.at(lane, displacements=rows).energy,  # type: ignore[misc]
                trial.states.displacements[lane],
            )
            energies = largest(answer.energy) / trial.body.size
            error = worst(answer.forces[0], estimates, largest(answer.forces, estimates[0], 1e-6 * energies))
            require(
                error < ACCURACY,
                f"{trial.what} adds forces that are not the derivatives of its energy, by {error:.2g} of the largest; "
                "internal forces are dE/du, with that sign.",
            )


def check_blocks_are_the_forces_derivatives(effect: EffectSubject, lattice: SpringLattice | None = None) -> None:
    """The blocks of a potential are the derivatives of its forces by the displacements, of all pairs of nodes."""
    ready = made_ready(effect)
    for trial in potentials(ready, lattice):
        require_blocks(trial, "displacements")


def check_expands_at_rest_as_claimed(effect: EffectSubject, lattice: SpringLattice | None = None) -> None:
    """Where it claims an expansion at rest, its forces have no kink there."""
    ready = made_ready(effect)
    for trial in potentials(ready, lattice) if ready.has_expansion_at_rest else ():
        u = trial.states.displacements[:1] / largest(trial.states.displacements[:1])
        steps = trial.body.size * np.array([0.0, 1e-1, -1e-1, 1e-4, -1e-4])
        rest, *forces = trial.at(0, displacements=steps[:, None] * u).forces
        far, near = (largest(forth + back - 2.0 * rest) for forth, back in (forces[:2], forces[2:]))
        require(
            near <= 1e-4 * far + 1e-12 * largest(rest, *forces),
            f"{trial.what} has no expansion at rest, where its forces have a kink; say has_expansion_at_rest = False.",
        )


def check_depends_on_the_stiffness_as_claimed(effect: EffectSubject, lattice: SpringLattice | None = None) -> None:
    """A potential is in proportion to the stiffness of each spring where it claims to be a law, else independent."""
    ready = made_ready(effect)
    for trial in potentials(ready, lattice):
        stiffness = trial.states.stiffness
        forces, other = (trial.answers(trial.states._replace(stiffness=k)).forces for k in (stiffness, stiffness[::-1]))
        scale = largest(forces, other)
        if not ready.scales_with_stiffness:
            require(
                bool(np.array_equal(forces, other)),
                f"{trial.what} depends on the stiffness of the springs; say scales_with_stiffness = True if it is a "
                "law of theirs, else leave the stiffness out.",
            )
            continue
        none, both = (
            trial.answers(trial.states._replace(stiffness=k)).forces
            for k in (0 * stiffness, stiffness + stiffness[::-1])
        )
        apart = trial.lattice
        pulls = pulls_of_law(
            ready, apart, trial.states.displacements, values=trial.values, fitted=trial.fitted, is_linear=False
        )
        assembled = np.zeros((len(pulls), *apart.nodes.shape))
        for lane, tensions in enumerate(stiffness[:, :, None] * pulls):
            np.subtract.at(assembled[lane], apart.springs[:, 0], tensions)
            np.add.at(assembled[lane], apart.springs[:, 1], tensions)
        stated = trial.answers(trial.states._replace(values=np.tile(trial.values, (len(pulls), 1)))).forces
        require(
            largest(none) == 0.0
            and largest(both - forces - other) <= ROUNDING * scale
            and largest(assembled.reshape(stated.shape) - stated) <= ROUNDING * scale,
            f"{trial.what} is no law of the springs, in proportion to the stiffness of each and of its two nodes "
            "alone; say scales_with_stiffness = False, or make it so.",
        )


def check_derivatives_by_parameters(effect: EffectSubject, lattice: SpringLattice | None = None) -> None:
    """The derivatives of the forces by the parameters, those of units where it claims to be affine, are differences."""
    ready = made_ready(effect)
    for trial in potentials(ready, lattice):
        for lane in LANES if len(trial.values) else ():
            state = trial.states.take(lane)
            try:
                claimed = force_derivatives(
                    ready,
                    trial.kernel,
                    trial.lattice,
                    state.displacements,
                    stiffness=state.stiffness,
                    values=state.values,
                    is_linear=False,
                )
            except AttributeError as missing:
                raise AssertionError(f"{missing}; override `force_derivatives`.") from missing
            require_array(f"force_derivatives of {trial.what}", claimed, (len(trial.values), trial.lattice.nodes.size))
            estimates = differences(
                lambda rows, trial=trial, lane=lane: trial.at(lane, values=rows).forces,  # type: ignore[misc]
                state.values,
            )
            error = worst(claimed, estimates, largest(claimed, estimates[0], 1e-6 * largest(trial.at(lane).forces)))
            mend = (
                "it is not affine in them: say is_affine = False and override `force_derivatives`"
                if ready.is_affine
                else "mend `force_derivatives`"
            )
            require(
                error < ACCURACY,
                f"{trial.what} has other derivatives by its parameters than it tells, by {error:.2g} of the largest; "
                f"{mend}.",
            )


def check_fitting_changes_no_force(effect: EffectSubject, lattice: SpringLattice | None = None) -> None:
    """Whichever parameters are fitted, constant forces, rest lengths and potential come to the same forces."""
    ready = made_ready(effect)
    for body in bodies_of(ready, lattice):
        states = body.states(flat(ready.parameters(body.lattice)))
        stated = [_whole_forces(ready, body.lattice, states, fitted) for fitted in choices_to_fit(ready, body.lattice)]
        for fitted, forces in zip(choices_to_fit(ready, body.lattice), stated, strict=True):
            require(
                largest(forces - stated[0]) <= ROUNDING * largest(*stated),
                f"{ready.name} on {body.title} comes to other forces where {', '.join(sorted(fitted))} is fitted; what "
                "is a constant force or a rest length there must be a potential then, and nothing twice.",
            )


def _whole_forces(effect: Effect, lattice: SpringLattice, states: States, fitted: frozenset[str]) -> Floats:
    """Internal forces of springs and effect, less the constant ones, at states with the values as stated."""
    used = lattice_with_its_rest_lengths(effect, lattice, fitted)
    forces = np.array([spring_forces(used, *row) for row in zip(states.displacements, states.stiffness, strict=True)])
    forces -= np.array(
        [spring_forces(lattice, *row) for row in zip(states.displacements, states.stiffness, strict=True)]
    )
    constant = constant_forces(effect, used, fitted)
    if constant is not None:
        forces -= constant.ravel()
    kernel = effect.potential(used, fitted)
    if kernel is not None:
        values = np.tile(flat(effect.parameters(used)), (len(forces), 1))
        try:
            forces += answers(kernel, used, states._replace(values=values)).forces
        except (Stray, Failed) as fault:
            raise NotJudged(f"the potential of {effect.name} has another fault ({fault}); mend that first.") from fault
    return forces
