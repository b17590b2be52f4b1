"""Checks of what an effect says of itself and brings without a kernel."""

from __future__ import annotations

import pickle
from itertools import chain

import numpy as np

from springopt.effects.effect import Effect, Kernel
from springopt.errors import UserError
from springopt.lattice import SpringLattice
from springopt.option_types import describe_type
from springopt.registry import effect_options
from springopt.testing.effect_trial import (
    EffectSubject,
    all_bodies,
    bodies_of,
    choices_to_fit,
    kernels,
)
from springopt.testing.effect_verdicts import (
    ROUNDING,
    made_ready,
    require_array,
    same_answers,
)
from springopt.testing.kernel_calls import Failed, Stray, answers
from springopt.testing.verdict import NotJudged, require, told


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
    ready = made_ready(effect)
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
    ready = made_ready(effect)
    for body in bodies_of(ready, lattice):
        for name, values in ready.parameters(body.lattice).items():
            legal = isinstance(values, np.ndarray) and values.ndim == 1 and values.dtype == float
            require(
                legal and bool(np.isfinite(values).all()) and "." not in name,
                f"parameter {name!r} of {ready.name} on {body.title} should be an array of finite floats of shape "
                f"(k,), under a name without a dot, but is {values!r}.",
            )


def check_constant_forces_fit_the_nodes(effect: EffectSubject, lattice: SpringLattice | None = None) -> None:
    """Constant forces are finite, shape (n, d)."""
    ready = made_ready(effect)
    for body in bodies_of(ready, lattice):
        forces = ready.constant_forces(body.lattice)
        if forces is not None:
            require_array(f"the constant forces of {ready.name} on {body.title}", forces, body.lattice.nodes.shape)


def check_rest_lengths_fit_the_springs(effect: EffectSubject, lattice: SpringLattice | None = None) -> None:
    """Rest lengths are finite and not negative, shape (s,)."""
    ready = made_ready(effect)
    for body in bodies_of(ready, lattice):
        rest_lengths = ready.rest_lengths(body.lattice)
        if rest_lengths is not None:
            what = f"the rest lengths of {ready.name} on {body.title}"
            require_array(what, rest_lengths, (body.lattice.spring_count,))
            require(bool(np.all(rest_lengths >= 0)), f"{what} should not be negative; refuse what makes them so.")


def check_masses_are_linear_in_the_parameters(effect: EffectSubject, lattice: SpringLattice | None = None) -> None:
    """Masses are not negative, shape (..., n) for parameters of shape (..., k), and linear in them."""
    ready = made_ready(effect)
    for body in bodies_of(ready, lattice):
        parameters = ready.parameters(body.lattice)
        masses = ready.masses(body.lattice, parameters)
        if masses is None:
            continue
        what = f"the masses of {ready.name} on {body.title}"
        require_array(what, masses, (body.lattice.node_count,))
        require(bool(np.all(masses >= 0)), f"{what} should not be negative; refuse what makes them so.")
        factors = np.arange(1.0, 7.0).reshape(3, 2, 1)
        several = ready.masses(body.lattice, {name: factors * values for name, values in parameters.items()})
        require_array(f"{what}, for parameters of shape (3, 2, k),", several, (3, 2, body.lattice.node_count))
        require(
            np.allclose(np.asarray(several), factors * masses, rtol=ROUNDING, atol=0.0),
            f"{what} should be linear in the parameters: twice as large where all of these are doubled.",
        )


def check_says_the_same_twice(effect: EffectSubject, lattice: SpringLattice | None = None) -> None:
    """Asked again, it brings the same to the bit: no randomness, no clock, nothing kept from call to call."""
    ready = made_ready(effect)
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
            same_answers(ones, others),
            f"{trial.what} does not answer the same twice; let it keep nothing from call to call.",
        )


def check_travels_to_other_processes(effect: EffectSubject, lattice: SpringLattice | None = None) -> None:
    """It can be pickled, as it is for workers, and is the same there."""
    ready = made_ready(effect)
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


def check_acts(effect: EffectSubject, lattice: SpringLattice | None = None) -> None:
    """It brings something, and a kernel something else than zero in the states of these checks."""
    ready = made_ready(effect)
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
