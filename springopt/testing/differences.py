"""Derivatives by Richardson's differences, by two steps, so that a kink or rounding spoils one of them alone."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from springopt.checks import Floats

STEPS = (2e-3, 2e-4)


def differences(function: Callable[[Floats], Floats], point: Floats) -> tuple[Floats, ...]:
    """By each step, the derivatives at a point (x,) of a function of rows (l, x) -> (l, ...), shape (x, ...)."""
    return tuple(_richardson(function, point, step) for step in STEPS)


def worst(claimed: Floats, estimates: tuple[Floats, ...], scale: float) -> float:
    """The largest difference of claimed derivatives from the closer estimate of each, as a share of a scale.

    Infinite where anything is not a number.
    """
    closest = np.min([np.abs(claimed - estimate) for estimate in estimates], axis=0)
    largest = float(np.max(closest, initial=0.0))
    if largest == 0.0:  # as of options that take the effect out
        return 0.0
    return largest / scale if np.isfinite(largest) else np.inf


def _richardson(function: Callable[[Floats], Floats], point: Floats, step: float) -> Floats:
    wide, narrow = _central(function, point, step), _central(function, point, step / 2)
    return (4.0 * narrow - wide) / 3.0


def _central(function: Callable[[Floats], Floats], point: Floats, step: float) -> Floats:
    steps = step * np.eye(len(point))
    values = function(np.concatenate([point + steps, point - steps]))
    return (values[: len(point)] - values[len(point) :]) / (2.0 * step)
