"""Random numbers that are data, as those of a random reference: their bits are the same with every version of NumPy.

Of a bit generator NumPy guarantees the stream of 64-bit words, of what is drawn from it nothing (NEP 19). So the words
are made into numbers here, with arithmetic that rounds alike everywhere and, for normal numbers, the standard library.
"""

from __future__ import annotations

from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray

from springopt.checks import Floats

Words = NDArray[np.uint64]


def random_words(count: int, seed: int, name: str = "") -> Words:
    """So many words of the stream that belongs to a seed and a name."""
    return np.random.PCG64([seed, *name.encode()]).random_raw(count)


def uniforms(words: Words) -> Floats:
    """Uniform in (0, 1), neither end included."""
    return ((words >> np.uint64(12)).astype(np.float64) + 0.5) * 2.0**-52


def normals(words: Words) -> Floats:
    """Of mean 0 and standard deviation 1, by the inverse of the distribution function."""
    return np.array([NormalDist().inv_cdf(share) for share in uniforms(words).tolist()])
