"""A reference as it is measured: with noise."""

from __future__ import annotations

from springopt.checks import Floats
from springopt.load_case import LoadCase
from springopt.reference.words import normals, random_words


def measured(positions: Floats, case: LoadCase, *, deviation: float, seed: int) -> Floats:
    """Positions [length], shape (n, d), with normal noise of this standard deviation in every free coordinate.

    What a load case is held at is known. Each load case has noise of its own, by its name: another one beside it does
    not change it.
    """
    noise = normals(random_words(positions.size, seed, case.name)).reshape(positions.shape)
    return positions + deviation * noise * case.free
