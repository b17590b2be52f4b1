"""Many tests at once."""

from __future__ import annotations

import numpy as np

from springopt.checks import Floats


def holm(p_values: Floats) -> Floats:
    """p-values, shape (tests,), such that with any level the chance of a single false finding among all is below it.

    Holm (*A simple sequentially rejective multiple test procedure*, Scand. J. Stat. 6, 1979).
    """
    order = np.argsort(p_values, kind="stable")
    stepped = p_values[order] * np.arange(len(p_values), 0, -1)
    adjusted = np.empty_like(p_values)
    adjusted[order] = np.minimum(np.maximum.accumulate(stepped), 1.0)
    return adjusted
