"""Conjugate gradients for eight systems side by side, each with its own matrix, all with one preconditioner."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Block = NDArray[np.float64]  # shape (unknowns, 8)

# Curvature below this share of the stiffness counts as none: no Newton step goes along such a direction.
FLAT_CURVATURE = 1e-12


def solve_lanes(
    multiply: Callable[[Block], Block],
    precondition: Callable[[Block], Block],
    sides: Block,
    is_wanted: NDArray[np.bool_],
    *,
    scale: Block,
    reduction: float,
    limit: int,
) -> tuple[Block, NDArray[np.bool_]]:
    """(x, which lanes were solved): K x = sides to this reduction of the preconditioned residual.

    A lane is left unsolved where its matrix or preconditioner curves down, or after `limit` products. `scale` is the
    stiffness that meets at each unknown. What happens in one lane never changes another.
    """
    x = np.zeros_like(sides)
    residual = np.where(is_wanted, sides, 0.0)
    z = precondition(residual)
    direction = z
    product = (residual * z).sum(axis=0)
    wanted = reduction**2 * product
    is_solved = is_wanted & (product == 0.0)
    is_open = is_wanted & (product > 0.0)
    for _ in range(limit):
        if not is_open.any():
            break
        pushed = multiply(direction)
        curvature = (direction * pushed).sum(axis=0)
        is_open &= curvature > FLAT_CURVATURE * (direction * scale * direction).sum(axis=0)
        step = np.divide(product, curvature, out=np.zeros_like(product), where=is_open)
        x += step * direction
        residual -= step * pushed
        z = precondition(residual)
        after = (residual * z).sum(axis=0)
        is_solved |= is_open & (after <= wanted)
        is_open &= ~is_solved & (after > 0.0)
        direction = z + np.divide(after, product, out=np.zeros_like(after), where=is_open) * direction
        product = after
    return x, is_solved
