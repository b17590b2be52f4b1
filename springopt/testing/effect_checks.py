"""The checks that every effect must pass, on small lattices that take a second or two together.

Each takes an effect, or its class to be checked with its defaults, and raises AssertionError with a sentence that says
what to mend. Each looks for one fault: where another one is in its way, it raises NotJudged. What an effect does not
bring is not checked. A plugin's whole test is `check_effect(MyEffect(...))`.
"""

from __future__ import annotations

import pickle
from collections.abc import Callable
from itertools import chain

import numpy as np

from springopt.checks import Floats
from springopt.effects.effect import Effect, Kernel
from springopt.effects.lanes import LANE_COUNT
from springopt.effects.probe import force_derivatives, pulls_of_law
from springopt.errors import UserError
from springopt.lattice import SpringLattice
from springopt.option_types import describe_type
from springopt.registry import effect_options
from springopt.testing.differences import differences, worst
from springopt.testing.effect_trial import (
    EffectSubject,
    KernelTrial,
    all_bodies,
    bodies_of,
    choices_to_fit,
    constant_forces,
    dissipations,
    flat,
    kernels,
    lattice_with_its_rest_lengths,
    matrix,
    potentials,
    spring_forces,
)
from springopt.testing.kernel_calls import Answers, Failed, States, Stray, answers, call
from springopt.testing.verdict import Finding, NotJudged, find, require, told

EffectCheck = Callable[..., None]

LANES = range(3)  # those of the states at which derivatives are compared
ACCURACY = 1e-6  # of derivatives by differences, beside the largest of them
ROUNDING = 1e-10  # of what should be equal but for the order of its sums


def check_effect(effect: EffectSubject, lattice: SpringLattice | None = None) -> None:
    """All checks, on a lattice or on small ones with cells of every kind that the effect does not refuse."""
    for check in EFFECT_CHECKS:
        check(effect, lattice)


def examine_effect(effect: EffectSubject, lattice: SpringLattice | None = None) -> list[Finding]:
    """What each check finds, in their order: to be read, where `check_effect` raises the first fault."""
    return [find(check, effect, lattice) for check in EFFECT_CHECKS]


def check_options_are_documented(effect: EffectSubject, lattice: SpringLattice | None = None) -> None:
    """A frozen dataclass with a name; every option has a type that a scene can write, and an explanation."""
    cls = effect if isinstance(effect, type) else type(effect)
    frozen = "__dataclass_params__" in vars(cls) and cls.__dataclass_params__.frozen  # type: ignore[attr-defined]
    require(frozen, f"{cls.__name__} must be a frozen dataclass: decorate it with @dataclass(frozen=True).")
    require(bool(cls.name), f"{cls.__name__} has no name; give it a class attribute.")
    require("." not in cls.name, f"the name {cls.name!r} has a dot, which parts effects from parameters; leave it out.")
    try:
        for option in effect_options(cls):
            require(
                bool(option.explanation), f"option {option.name} of {cls.name} has no explanation; put one behind #:."
            )
            describe_type(option.type)
    except UserError as error:
        raise AssertionError(f"{cls.name} states an illegal option: {error}") from error


def check_runs_or_refuses_in_a_sentence(effect: EffectSubject, lattice: SpringLattice | None = None) -> None:
    """On every lattice it either says what it brings, or raises a UserError; at least one lattice is served."""
    ready = _ready(effect)
    bodies = [body.lattice for body in all_bodies()] if lattice is None else [lattice]
    for each in bodies:
        try:
            _declarations(ready, each)
        except UserError:
            continue
        except Exception as error:
            raise AssertionError(
                f"{ready.name} fails on a lattice of {each.node_count} nodes in {each.dimension}D ({told(error)}); "
                "mend it, or refuse such a lattice by a UserError in `parameters`."
            ) from error
    for trial in kernels(ready, lattice):
        try:
            answers(trial.kernel, trial.lattice, trial.states)
        except Failed as error:
            raise AssertionError(f"{trial.what} fails ({error}); mend it.") from error
        except Stray:
            continue  # for another check


def check_parameters_are_rows_of_numbers(effect: EffectSubject, lattice: SpringLattice | None = None) -> None:
    """Each of `parameters` has a name without a dot, and its value here: finite floats of shape (k,)."""
    ready = _ready(effect)
    for body in bodies_of(ready, lattice):
        for name, values in ready.parameters(body.lattice).items():
            legal = isinstance(values, np.ndarray) and values.ndim == 1 and values.dtype == float
            require(
                legal and bool(np.isfinite(values).all()) and "." not in name,
                f"parameter {name!r} of {ready.name} on {body.title} should be an array of finite floats of shape "
                f"(k,), under a name without a dot, but is {values!r}.",
            )


def check_says_the_same_twice(effect: EffectSubject, lattice: SpringLattice | None = None) -> None:
    """Asked again, it brings the same to the bit: no randomness, no clock, nothing kept from call to call."""
    ready = _ready(effect)
    for body in bodies_of(ready, lattice):
        once, again = (_bits(ready, body.lattice) for _ in range(2))
        require(
            once == again,
            f"{ready.name} does not bring the same to {body.title} when it is asked twice; let what it brings depend "
            "on its options and the lattice alone.",
        )
    for trial in kernels(ready, lattice):
        ones, others = (trial.answers(trial.states) for _ in range(2))
        require(
            _same(ones, others),
            f"{trial.what} does not answer the same twice; let it keep nothing from call to call.",
        )


def check_travels_to_other_processes(effect: EffectSubject, lattice: SpringLattice | None = None) -> None:
    """It can be pickled, as it is for workers, and is the same there."""
    ready = _ready(effect)
    try:
        copy = pickle.loads(pickle.dumps(ready))
    except Exception as error:
        raise AssertionError(
            f"{ready.name} can't be sent to workers ({told(error)}); keep options alone in its fields, and make "
            "kernels where they are asked for."
        ) from error
    for body in bodies_of(ready, lattice):
        require(
            _bits(copy, body.lattice) == _bits(ready, body.lattice) or not _is_repeatable(ready, body.lattice),
            f"{ready.name} brings something else to {body.title} after it was sent to a worker; let what it brings "
            "depend on its fields alone.",
        )


def check_constant_forces_fit_the_nodes(effect: EffectSubject, lattice: SpringLattice | None = None) -> None:
    """Constant forces are finite, shape (n, d)."""
    ready = _ready(effect)
    for body in bodies_of(ready, lattice):
        forces = ready.constant_forces(body.lattice)
        if forces is not None:
            _require_array(f"the constant forces of {ready.name} on {body.title}", forces, body.lattice.nodes.shape)


def check_rest_lengths_fit_the_springs(effect: EffectSubject, lattice: SpringLattice | None = None) -> None:
    """Rest lengths are finite and not negative, shape (s,)."""
    ready = _ready(effect)
    for body in bodies_of(ready, lattice):
        rest_lengths = ready.rest_lengths(body.lattice)
        if rest_lengths is not None:
            what = f"the rest lengths of {ready.name} on {body.title}"
            _require_array(what, rest_lengths, (body.lattice.spring_count,))
            require(bool(np.all(rest_lengths >= 0)), f"{what} should not be negative; refuse what makes them so.")


def check_masses_are_linear_in_the_parameters(effect: EffectSubject, lattice: SpringLattice | None = None) -> None:
    """Masses are not negative, shape (..., n) for parameters of shape (..., k), and linear in them."""
    ready = _ready(effect)
    for body in bodies_of(ready, lattice):
        parameters = ready.parameters(body.lattice)
        masses = ready.masses(body.lattice, parameters)
        if masses is None:
            continue
        what = f"the masses of {ready.name} on {body.title}"
        _require_array(what, masses, (body.lattice.node_count,))
        require(bool(np.all(masses >= 0)), f"{what} should not be negative; refuse what makes them so.")
        factors = np.arange(1.0, 7.0).reshape(3, 2, 1)
        several = ready.masses(body.lattice, {name: factors * values for name, values in parameters.items()})
        _require_array(f"{what}, for parameters of shape (3, 2, k),", several, (3, 2, body.lattice.node_count))
        require(
            np.allclose(np.asarray(several), factors * masses, rtol=ROUNDING, atol=0.0),
            f"{what} should be linear in the parameters: twice as large where all of these are doubled.",
        )


def check_keeps_to_its_places(effect: EffectSubject, lattice: SpringLattice | None = None) -> None:
    """A kernel adds to forces, energy and the blocks of the pairs that it declared, where their places say, alone."""
    ready = _ready(effect)
    for trial in kernels(ready, lattice):
        _require_legal(trial.what, trial.kernel, trial.lattice)
        d, q = trial.lattice.dimension, len(trial.kernel.pairs)
        size = d * d
        stored = 2 * size * np.arange(q, dtype=np.int64)
        off = trial.kernel.pairs[:, 0] != trial.kernel.pairs[:, 1]
        try:
            plain = call(trial.kernel, trial.lattice, trial.states, stored, size * q)
            later = call(trial.kernel, trial.lattice, trial.states, stored, size * q, before=0.5)
            turned = call(trial.kernel, trial.lattice, trial.states, stored + off, size * q)
            dropped = call(trial.kernel, trial.lattice, trial.states, np.full(q, -1), size)
        except Failed as error:
            raise NotJudged(f"{trial.what} fails ({error}); mend that first.") from error
        except Stray as stray:
            raise AssertionError(
                f"{trial.what} {stray}; keep to the pairs that are declared, in their order, and to n d forces."
            ) from stray
        require(
            all(
                np.allclose(b - 0.5, a, rtol=0, atol=1e-9 * _largest(a, 0.5)) for a, b in zip(plain, later, strict=True)
            ),
            f"{trial.what} does not add to what is there; use `add` and `add_to_block`, never `store` alone.",
        )
        blocks, transposed = (tangent.reshape(q, d, d, LANE_COUNT) for tangent in (plain[2], turned[2]))
        blocks = np.where(off[:, None, None, None], blocks.swapaxes(1, 2), blocks)
        require(
            bool(np.array_equal(blocks, transposed, equal_nan=True)) and not dropped[2].any(),
            f"{trial.what} does not put its blocks where their places say: -1 drops a block, an odd place transposes "
            "it; let `add_to_block` do that.",
        )


def check_lanes_are_independent(effect: EffectSubject, lattice: SpringLattice | None = None) -> None:
    """An answer is the same to the bit whatever states it is computed beside."""
    ready = _ready(effect)
    for trial in kernels(ready, lattice):
        together = trial.answers(trial.states)
        count = len(together.energy)
        order = (np.arange(count) + 3) % count
        moved = trial.answers(trial.states.take(order))
        alone = [trial.answers(trial.states.take([lane])) for lane in range(count)]
        are_alike = _same(Answers(*(array[order] for array in together)), moved) and _same(
            together, Answers(*(np.concatenate(arrays) for arrays in zip(*alone, strict=True)))
        )
        require(
            are_alike,
            f"{trial.what} answers otherwise beside other states; let every lane do the same whatever the others hold.",
        )


def check_is_finite_everywhere(effect: EffectSubject, lattice: SpringLattice | None = None) -> None:
    """No NaN and no infinity at rest, where all nodes are at one place, or where the body is inside out."""
    ready = _ready(effect)
    for trial in kernels(ready, lattice):
        nodes = trial.lattice.nodes
        mirrored = nodes * ([-1.0] + [1.0] * (nodes.shape[1] - 1))
        shapes = {"at rest": nodes, "where all nodes are at one place": np.zeros_like(nodes), "inside out": mirrored}
        for where, positions in shapes.items():
            answer = trial.at(0, displacements=(positions - nodes).reshape(1, -1))
            require(
                all(bool(np.isfinite(array).all()) for array in answer),
                f"{trial.what} is not finite {where}; guard its quotients and roots, as an equilibrium is searched "
                "through any state.",
            )


def check_acts(effect: EffectSubject, lattice: SpringLattice | None = None) -> None:
    """It brings something, and a kernel something else than zero in the states of these checks."""
    ready = _ready(effect)
    for body in bodies_of(ready, lattice):
        brought = _declarations(ready, body.lattice)
        require(
            any(one is not None for one in brought), f"{ready.name} brings nothing to {body.title}; override a method."
        )
    for trial in kernels(ready, lattice):
        if not trial.answers(trial.states).forces.any():
            raise NotJudged(
                f"{trial.what} is zero in all states here; give check_effect options or a lattice where it acts."
            )


def check_forces_are_the_energys_derivatives(effect: EffectSubject, lattice: SpringLattice | None = None) -> None:
    """The forces of a potential are the derivatives of its energy by the displacements."""
    ready = _ready(effect)
    for trial in potentials(ready, lattice):
        for lane in LANES:
            answer = trial.at(lane)
            estimates = differences(
                lambda rows, trial=trial, lane=lane: trial.at(lane, displacements=rows).energy,  # type: ignore[misc]
                trial.states.displacements[lane],
            )
            energies = _largest(answer.energy) / trial.body.size
            error = worst(answer.forces[0], estimates, _largest(answer.forces, estimates[0], 1e-6 * energies))
            require(
                error < ACCURACY,
                f"{trial.what} adds forces that are not the derivatives of its energy, by {error:.2g} of the largest; "
                "internal forces are dE/du, with that sign.",
            )


def check_blocks_are_the_forces_derivatives(effect: EffectSubject, lattice: SpringLattice | None = None) -> None:
    """The blocks of a potential are the derivatives of its forces by the displacements, of all pairs of nodes."""
    ready = _ready(effect)
    for trial in potentials(ready, lattice):
        _require_blocks(trial, "displacements")


def check_expands_at_rest_as_claimed(effect: EffectSubject, lattice: SpringLattice | None = None) -> None:
    """Where it claims an expansion at rest, its forces have no kink there."""
    ready = _ready(effect)
    for trial in potentials(ready, lattice) if ready.has_expansion_at_rest else ():
        u = trial.states.displacements[:1] / _largest(trial.states.displacements[:1])
        steps = trial.body.size * np.array([0.0, 1e-1, -1e-1, 1e-4, -1e-4])
        rest, *forces = trial.at(0, displacements=steps[:, None] * u).forces
        far, near = (_largest(forth + back - 2.0 * rest) for forth, back in (forces[:2], forces[2:]))
        require(
            near <= 1e-4 * far + 1e-12 * _largest(rest, *forces),
            f"{trial.what} has no expansion at rest, where its forces have a kink; say has_expansion_at_rest = False.",
        )


def check_depends_on_the_stiffness_as_claimed(effect: EffectSubject, lattice: SpringLattice | None = None) -> None:
    """A potential is in proportion to the stiffness of each spring where it claims to be a law, else independent."""
    ready = _ready(effect)
    for trial in potentials(ready, lattice):
        stiffness = trial.states.stiffness
        forces, other = (trial.answers(trial.states._replace(stiffness=k)).forces for k in (stiffness, stiffness[::-1]))
        scale = _largest(forces, other)
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
            _largest(none) == 0.0
            and _largest(both - forces - other) <= ROUNDING * scale
            and _largest(assembled.reshape(stated.shape) - stated) <= ROUNDING * scale,
            f"{trial.what} is no law of the springs, in proportion to the stiffness of each and of its two nodes "
            "alone; say scales_with_stiffness = False, or make it so.",
        )


def check_derivatives_by_parameters(effect: EffectSubject, lattice: SpringLattice | None = None) -> None:
    """The derivatives of the forces by the parameters, those of units where it claims to be affine, are differences."""
    ready = _ready(effect)
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
            _require_array(f"force_derivatives of {trial.what}", claimed, (len(trial.values), trial.lattice.nodes.size))
            estimates = differences(
                lambda rows, trial=trial, lane=lane: trial.at(lane, values=rows).forces,  # type: ignore[misc]
                state.values,
            )
            error = worst(claimed, estimates, _largest(claimed, estimates[0], 1e-6 * _largest(trial.at(lane).forces)))
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
    ready = _ready(effect)
    for body in bodies_of(ready, lattice):
        states = body.states(flat(ready.parameters(body.lattice)))
        stated = [_whole_forces(ready, body.lattice, states, fitted) for fitted in choices_to_fit(ready, body.lattice)]
        for fitted, forces in zip(choices_to_fit(ready, body.lattice), stated, strict=True):
            require(
                _largest(forces - stated[0]) <= ROUNDING * _largest(*stated),
                f"{ready.name} on {body.title} comes to other forces where {', '.join(sorted(fitted))} is fitted; what "
                "is a constant force or a rest length there must be a potential then, and nothing twice.",
            )


def check_rigid_motions_cost_nothing(effect: EffectSubject, lattice: SpringLattice | None = None) -> None:
    """Where it claims to be invariant, net force and torque are zero, and rigid motions dissipate nothing."""
    ready = _ready(effect)
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
            usual = _largest(trial.at(lane).energy)
            for claim, velocity in _rigid_motions(ready, positions):
                power = _largest(trial.at(lane, velocities=velocity.reshape(1, -1)).energy)
                require(
                    power <= ROUNDING * usual,
                    f"{trial.what} dissipates in a rigid motion; say {claim} = False, or make it so.",
                )


def check_dissipation_takes_power(effect: EffectSubject, lattice: SpringLattice | None = None) -> None:
    """The power of a dissipation is velocity times force, is never negative, and zero where nothing moves."""
    ready = _ready(effect)
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
    ready = _ready(effect)
    for trial in dissipations(ready, lattice):
        _require_blocks(trial, "velocities")


EFFECT_CHECKS: tuple[EffectCheck, ...] = (
    check_options_are_documented,
    check_runs_or_refuses_in_a_sentence,
    check_parameters_are_rows_of_numbers,
    check_constant_forces_fit_the_nodes,
    check_rest_lengths_fit_the_springs,
    check_masses_are_linear_in_the_parameters,
    check_keeps_to_its_places,
    check_says_the_same_twice,
    check_travels_to_other_processes,
    check_lanes_are_independent,
    check_is_finite_everywhere,
    check_acts,
    check_forces_are_the_energys_derivatives,
    check_blocks_are_the_forces_derivatives,
    check_expands_at_rest_as_claimed,
    check_depends_on_the_stiffness_as_claimed,
    check_derivatives_by_parameters,
    check_fitting_changes_no_force,
    check_rigid_motions_cost_nothing,
    check_dissipation_takes_power,
    check_dissipation_blocks_are_derivatives,
)


def _ready(effect: EffectSubject) -> Effect:
    if isinstance(effect, Effect):
        return effect
    try:
        return effect()
    except Exception as error:
        raise NotJudged(f"{effect.__name__} can't be made with its defaults ({told(error)}).") from error


def _declarations(effect: Effect, lattice: SpringLattice) -> list[object]:
    """Everything that it brings, fitted or not, in the order of the contract."""
    parameters = effect.parameters(lattice)
    brought: list[object] = [effect.dissipation(lattice), effect.masses(lattice, parameters)]
    for fitted in choices_to_fit(effect, lattice):
        brought += [effect.constant_forces(lattice, fitted), effect.rest_lengths(lattice, fitted)]
        brought.append(effect.potential(lattice, fitted))
    return brought


def _bits(effect: Effect, lattice: SpringLattice) -> list[object]:
    parameters = effect.parameters(lattice)
    return [
        *chain.from_iterable((name, np.asarray(values).tobytes()) for name, values in parameters.items()),
        *(_bits_of(brought) for brought in _declarations(effect, lattice)),
    ]


def _bits_of(brought: object) -> object:
    if isinstance(brought, Kernel):
        return [np.asarray(array).tobytes() for array in (brought.pairs, brought.integers, brought.numbers)]
    return brought if brought is None else np.asarray(brought).tobytes()


def _is_repeatable(effect: Effect, lattice: SpringLattice) -> bool:
    return _bits(effect, lattice) == _bits(effect, lattice)


def _same(ones: Answers, others: Answers) -> bool:
    return all(np.array_equal(one, other, equal_nan=True) for one, other in zip(ones, others, strict=True))


def _require_array(what: str, array: object, shape: tuple[int, ...]) -> None:
    came = f"{array.dtype} of shape {array.shape}" if isinstance(array, np.ndarray) else type(array).__name__
    require(
        isinstance(array, np.ndarray) and array.shape == shape and bool(np.isfinite(array).all()),
        f"{what} should be an array of finite numbers of shape {shape}, but came as {came}.",
    )


def _require_legal(what: str, kernel: Kernel, lattice: SpringLattice) -> None:
    pairs = kernel.pairs
    for name, array, kind in (
        ("pairs", pairs, np.int64),
        ("integers", kernel.integers, np.int64),
        ("numbers", kernel.numbers, np.float64),
    ):
        require(
            isinstance(array, np.ndarray) and array.dtype == kind and array.flags.c_contiguous,
            f"the {name} of {what} should be a contiguous array of {kind.__name__}, which a pointer leads to.",
        )
    legal = pairs.ndim == 2 and pairs.shape[1] == 2 and bool(np.all((pairs >= 0) & (pairs < lattice.node_count)))
    require(legal, f"the pairs of {what} should be nodes of the lattice, shape (q, 2).")


def _require_blocks(trial: KernelTrial, by: str) -> None:
    for lane in LANES:
        answer = trial.at(lane)
        claimed = matrix(trial.kernel, answer.blocks[0], trial.lattice.node_count)
        estimates = differences(
            lambda rows, lane=lane: trial.at(lane, **{by: rows}).forces,  # type: ignore[misc]
            getattr(trial.states, by)[lane],
        )
        # Rows of the differences belong to what was moved, and columns to forces.
        turned = tuple(estimate.T for estimate in estimates)
        forces = _largest(answer.forces) / trial.body.size
        error = worst(claimed, turned, _largest(claimed, turned[0], 1e-6 * forces))
        skew = _largest(turned[0] - turned[0].T) / _largest(turned[0], 1e-6 * forces)
        if skew > ACCURACY and error > ACCURACY:
            raise NotJudged(
                f"{trial.what} has forces whose derivatives are not symmetric, as no blocks are; mend them."
            )
        require(
            error < ACCURACY,
            f"{trial.what} adds blocks that are not the derivatives of its forces by the {by}, by {error:.2g} of the "
            "largest; declare every pair of nodes that act on each other, once, and add dF_i / du_j.",
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


def _require_balance(effect: Effect, what: str, positions: Floats, forces: Floats) -> None:
    net = _largest(forces.sum(axis=0))
    require(
        not effect.is_translation_invariant or net <= ROUNDING * np.abs(forces).sum(),
        f"{what} has a net force, so that moving the body costs energy; say is_translation_invariant = False.",
    )
    torques = positions[:, :, None] * forces[:, None, :]
    torques = torques - torques.swapaxes(1, 2)
    require(
        not effect.is_rotation_invariant or _largest(torques.sum(axis=0)) <= ROUNDING * np.abs(torques).sum(),
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


def _largest(*arrays: Floats | float) -> float:
    """The largest magnitude in arrays or numbers; 0 where there are none."""
    return max((float(np.max(np.abs(array), initial=0.0)) for array in arrays), default=0.0)
