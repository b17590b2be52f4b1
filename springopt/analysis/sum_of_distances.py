"""The minimum over a box of a sum of distances |A_i z - b_i|: what a median is to a mean.

The distances have kinks at zero, where many of them end. Each is made smooth, sqrt(|.|^2 + mu^2), and mu falls by tens;
for each mu Newton's method, projected on the box (Bertsekas 1982, SIAM J. Control Optim. 20), is at its minimum in a
few steps.
"""

from __future__ import annotations

import numpy as np

from springopt.checks import Floats

SMOOTHINGS = 0.1 ** np.arange(1, 12)  # shares of the mean distance at the start
STEPS = 40  # for one smoothing
SHORTEST_STEP = 1e-8
CONVERGED = 1e-13  # of the box's width


def least_sum_of_distances(blocks: Floats, goals: Floats, start: Floats, lower: Floats, upper: Floats) -> Floats:
    """The point, shape (u,), where sum |A_i z - b_i| is least, to about 1e-10.

    `blocks` A (n, d, u), `goals` b (n, d); `start` (u,) lies in the box.
    """
    scale = float(np.linalg.norm(blocks @ start - goals, axis=1).mean())
    z = start
    for share in SMOOTHINGS if scale > 0 else ():
        for _ in range(STEPS):
            last, z = z, _newton_step(blocks, goals, z, lower, upper, share * scale)
            if np.abs(z - last).max() <= CONVERGED * (upper - lower).max():
                break
    return z


def _newton_step(blocks: Floats, goals: Floats, z: Floats, lower: Floats, upper: Floats, smoothing: float) -> Floats:
    """The next point, lower in the smooth sum; the same one where none is."""
    differences = blocks @ z - goals
    lengths = np.sqrt((differences**2).sum(axis=1) + smoothing**2)
    directions = differences / lengths[:, None]
    gradient = np.einsum("nd,ndu->u", directions, blocks)
    inward = ~(((z <= lower) & (gradient > 0)) | ((z >= upper) & (gradient < 0)))
    if not inward.any():
        return z
    step = np.zeros_like(z)
    step[inward] = _solve(_hessian(blocks[:, :, inward], directions, lengths), -gradient[inward])
    length = 1.0
    while length >= SHORTEST_STEP:
        trial = np.clip(z + length * step, lower, upper)
        change = np.sqrt(((blocks @ trial - goals) ** 2).sum(axis=1) + smoothing**2) - lengths
        if change.sum() < 0:
            return trial
        length /= 4
    return z


def _hessian(blocks: Floats, directions: Floats, lengths: Floats) -> Floats:
    """Of the smooth sum: each distance resists what turns it, and what lengthens it as far as it is smoothed."""
    along = np.einsum("nd,ndu->nu", directions, blocks)
    scaled = (blocks / np.sqrt(lengths)[:, None, None]).reshape(-1, blocks.shape[2])
    scaled_along = along / np.sqrt(lengths)[:, None]
    return scaled.T @ scaled - scaled_along.T @ scaled_along


def _solve(matrix: Floats, right: Floats) -> Floats:
    """With as much of the diagonal added as a direction without curvature needs."""
    diagonal = np.diag(matrix)
    scales = np.sqrt(np.where(diagonal > np.finfo(float).tiny, diagonal, 1.0))
    scaled = matrix / np.outer(scales, scales)
    return np.linalg.solve(scaled + 1e-12 * np.eye(len(scaled)), right / scales) / scales
