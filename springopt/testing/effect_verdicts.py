"""What the checks of effects share: how it is told whether numbers agree."""

from __future__ import annotations

import numpy as np

from springopt.checks import Floats
from springopt.effects.effect import Effect
from springopt.testing.differences import differences, worst
from springopt.testing.effect_trial import (
    EffectSubject,
    KernelTrial,
    matrix,
)
from springopt.testing.kernel_calls import Answers
from springopt.testing.verdict import NotJudged, require, told

LANES = range(3)  # those of the states at which derivatives are compared
ACCURACY = 1e-6  # of derivatives by differences, beside the largest of them
ROUNDING = 1e-10  # of what should be equal but for the order of its sums


def made_ready(effect: EffectSubject) -> Effect:
    if isinstance(effect, Effect):
        return effect
    try:
        return effect()
    except Exception as error:
        raise NotJudged(f"{effect.__name__} can't be made with its defaults ({told(error)}).") from error


def same_answers(ones: Answers, others: Answers) -> bool:
    return all(np.array_equal(one, other, equal_nan=True) for one, other in zip(ones, others, strict=True))


def require_array(what: str, array: object, shape: tuple[int, ...]) -> None:
    came = f"{array.dtype} of shape {array.shape}" if isinstance(array, np.ndarray) else type(array).__name__
    require(
        isinstance(array, np.ndarray) and array.shape == shape and bool(np.isfinite(array).all()),
        f"{what} should be an array of finite numbers of shape {shape}, but came as {came}.",
    )


def require_blocks(trial: KernelTrial, by: str) -> None:
    for lane in LANES:
        answer = trial.at(lane)
        claimed = matrix(trial.kernel, answer.blocks[0], trial.lattice.node_count)
        estimates = differences(
            lambda rows, lane=lane: trial.at(lane, **{by: rows}).forces,  # type: ignore[misc]
            getattr(trial.states, by)[lane],
        )
        # Rows of the differences belong to what was moved, and columns to forces.
        turned = tuple(estimate.T for estimate in estimates)
        forces = largest(answer.forces) / trial.body.size
        error = worst(claimed, turned, largest(claimed, turned[0], 1e-6 * forces))
        skew = largest(turned[0] - turned[0].T) / largest(turned[0], 1e-6 * forces)
        if skew > ACCURACY and error > ACCURACY:
            raise NotJudged(
                f"{trial.what} has forces whose derivatives are not symmetric, as no blocks are; mend them."
            )
        require(
            error < ACCURACY,
            f"{trial.what} adds blocks that are not the derivatives of its forces by the {by}, by {error:.2g} of the "
            "largest; declare every pair of nodes that act on each other, once, and add dF_i / du_j.",
        )


def largest(*arrays: Floats | float) -> float:
    """The largest magnitude in arrays or numbers; 0 where there are none."""
    return max((float(np.max(np.abs(array), initial=0.0)) for array in arrays), default=0.0)
