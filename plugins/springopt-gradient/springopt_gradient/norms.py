"""The minimum of a weighted sum of norms of linear functions in a box, by a primal-dual Newton method."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from springopt.checks import Floats
from springopt_gradient.quadratic import minimize_in_box

#: Norms are rounded off below these shares of their mean, one a Newton step; the last one is repeated.
ROUNDINGS = np.maximum(0.3 ** np.arange(1, 41), 1e-9)
#: Steps below this share of the box end the search.
SETTLED = 1e-8
#: The share of the way to where a dual vector has length 1.
DUAL_SHARE = 0.99
#: Makes up for what rounding does to the curvature, in units of its largest entry.
LIFT = 1e-14
#: Armijo's: the least share of the promised decrease; and the shortest share of a step.
SUFFICIENT, SHORTEST = 1e-4, 1e-4


@dataclass(frozen=True, eq=False)
class SumOfNorms:
    """The sum of weights . |residuals + jacobian d|, as a function of a step d in shares of the box, shape (size,)."""

    residuals: Floats  #: shape (p, m)
    jacobian: Floats  #: shape (p, m, size)
    weights: Floats  #: shape (p,)

    def step(self, damping: float, lower: Floats, upper: Floats) -> Floats:
        """The step in [lower, upper] where the sum + damping x mean curvature x |d|^2 / 2 is least.

        Norms are rounded off to sqrt(|e|^2 + rounding^2), less and less, and the directions of the residuals are
        unknowns of their own: so Newton's steps do not shrink with the rounding, and residuals that can be zero become
        zero. Chan, Golub and Mulet (1999); Andersen, Christiansen, Conn and Overton (2000).
        """
        jacobian, weights = self.jacobian.reshape(-1, self.jacobian.shape[2]), self.weights
        mean, stiffness = np.linalg.norm(self.residuals, axis=1).mean(), damping * self._mean_curvature()
        d, errors = np.zeros(jacobian.shape[1]), self.residuals
        duals = errors / _lengths(errors, mean * ROUNDINGS[0])[:, None]
        for rounding in mean * ROUNDINGS:
            lengths = _lengths(errors, rounding)
            slope = jacobian.T @ (errors * (weights / lengths)[:, None]).ravel() + stiffness * d
            curvature = self._curvature(errors, duals, lengths)
            lift = stiffness + LIFT * np.diag(curvature).max()
            step = minimize_in_box(curvature + lift * np.eye(len(d)), slope, lower - d, upper - d)
            moves = (jacobian @ step).reshape(errors.shape)
            duals = _advanced(duals, errors, moves, lengths)
            share, highest, fall = 1.0, self._height(errors, rounding, stiffness, d), SUFFICIENT * (slope @ step)
            while self._height(errors + share * moves, rounding, stiffness, d + share * step) > highest + share * fall:
                share *= 0.5
                if share < SHORTEST:
                    break
            d, errors = d + share * step, errors + share * moves
            if rounding == mean * ROUNDINGS[-1] and np.abs(step).max() <= SETTLED:
                break
        return np.clip(d, lower, upper)

    def _mean_curvature(self) -> float:
        """That of parabolas which touch the norms where these have their mean."""
        mean = self.weights @ np.linalg.norm(self.residuals, axis=1) / self.weights.sum()
        return float(self.weights @ (self.jacobian**2).sum(axis=(1, 2)) / (mean * self.jacobian.shape[2]))

    def _curvature(self, errors: Floats, duals: Floats, lengths: Floats) -> Floats:
        """Of the Newton step, shape (size, size), made symmetric: semidefinite while no dual is longer than 1."""
        crossed = duals[:, :, None] * (errors / lengths[:, None])[:, None, :]
        blocks = np.eye(errors.shape[1]) - 0.5 * (crossed + crossed.transpose(0, 2, 1))
        values, vectors = np.linalg.eigh(blocks)
        roots = vectors * np.sqrt(np.maximum(values, 0.0) * (self.weights / lengths)[:, None])[:, None, :]
        scaled = np.matmul(roots.transpose(0, 2, 1), self.jacobian).reshape(-1, self.jacobian.shape[2])
        return scaled.T @ scaled

    def _height(self, errors: Floats, rounding: float, stiffness: float, d: Floats) -> float:
        return float(self.weights @ _lengths(errors, rounding) + 0.5 * stiffness * (d @ d))


def _lengths(errors: Floats, rounding: float) -> Floats:
    return np.sqrt((errors**2).sum(axis=1) + rounding**2)


def _advanced(duals: Floats, errors: Floats, moves: Floats, lengths: Floats) -> Floats:
    """The duals after their Newton step, cut short where one of them would leave the unit ball."""
    along = (errors * moves).sum(axis=1) / lengths
    steps = (errors + moves - duals * along[:, None]) / lengths[:, None] - duals
    inside, across, size = (duals**2).sum(axis=1) - 1.0, (duals * steps).sum(axis=1), (steps**2).sum(axis=1)
    moving = size > 1e-20
    reach = (np.sqrt(np.maximum(across**2 - size * inside, 0.0)) - across)[moving] / size[moving]
    return duals + min(1.0, DUAL_SHARE * float(reach.min(initial=2.0))) * steps
