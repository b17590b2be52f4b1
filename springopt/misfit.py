"""How far a model's positions are from the reference's, per load case; one number a definition."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from springopt.checks import Floats

# A distance below this share of the smallest rest length counts as zero in a gradient, where the mean has a kink.
AT_KINK = 1e-14


@dataclass(frozen=True)
class Misfit:
    """A definition of distance between positions (..., n, d), and its gradient with respect to the first ones."""

    name: str
    value: Callable[[Floats, float], Floats]  #: differences (..., n, d), smallest rest length -> (...)
    gradient: Callable[[Floats, float], Floats]  #: the same -> (..., n, d)


def _mean_distance(differences: Floats, smallest: float) -> Floats:
    return np.sqrt((differences**2).sum(axis=-1)).mean(axis=-1)


def _mean_distance_gradient(differences: Floats, smallest: float) -> Floats:
    distances = np.sqrt((differences**2).sum(axis=-1, keepdims=True))
    directions = np.divide(differences, distances, out=np.zeros_like(differences), where=distances > AT_KINK * smallest)
    return directions / differences.shape[-2]


def _half_squares(differences: Floats, smallest: float) -> Floats:
    return 0.5 * (differences**2).sum(axis=(-2, -1))


MISFITS = {
    misfit.name: misfit
    for misfit in (
        # The mean distance between nodes of model and reference, Bianchi et al. (2004).
        Misfit("distance", _mean_distance, _mean_distance_gradient),
        # The same over the smallest rest length, the error of their Figure 3.
        Misfit(
            "relative-distance",
            lambda differences, smallest: _mean_distance(differences, smallest) / smallest,
            lambda differences, smallest: _mean_distance_gradient(differences, smallest) / smallest,
        ),
        # Half the sum of squared coordinate differences: what least-squares methods minimize.
        Misfit("least-squares", _half_squares, lambda differences, smallest: differences),
    )
}
