"""Numbers of a comparison in few characters, for tables and figures."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

#: What running times are counted in, for people.
UNITS = {"evaluations": "evaluations", "solves": "solves", "processor_seconds": "processor seconds"}

SOLVED = 1e-6  # the last target: gaps up to there are shown, ranked and tested as equal


def power(exponent: int) -> str:
    """A target, by what is left of the way."""
    return f"1e-{exponent}"


def gap(share: float) -> str:
    """What is left of the way."""
    if share <= SOLVED:
        return "solved"
    return f"{share:.2g}" if 0.001 <= share < 99.5 else f"{share:.1e}"


def short(number: float) -> str:
    """Three digits, without powers of ten for large numbers."""
    if math.isinf(number):
        return "inf"
    return f"{number:,.0f}" if number >= 999.5 else f"{number:.3g}"


def brief(number: float) -> str:
    """At most four characters or so, for cells of a figure: 0.012, 3.4, 56, 7.8k, 90k, 1.2M."""
    for size, letter in ((1e6, "M"), (1e3, "k")):
        if number >= 0.9995 * size:
            return f"{number / size:.2g}{letter}" if number < 99.5 * size else f"{number / size:.0f}{letter}"
    return f"{number:.2g}" if number < 99.5 else f"{number:.0f}"


def ratio(number: float | None) -> str:
    """How many times the best; - where there is no best."""
    if number is None:
        return "-"
    return "never" if math.isinf(number) else short(number)


def estimate(found: Mapping[str, Any]) -> str:
    """A value with its interval, where that has a width."""
    if math.isinf(found["value"]):
        return "never"
    value, low, high = (short(found[name]) for name in ("value", "low", "high"))
    return value if low == high else f"{value} ({low} to {high})"


def failed(count: int) -> str:
    """What to add to a number of runs, where more of them failed."""
    return f" ({count} failed)" if count else ""


def error(number: float | None) -> str:
    """Three digits; - where there is none."""
    return "-" if number is None else f"{number:.3g}"


def p_value(p: float | None) -> str:
    """Three decimals, or the power of ten of what is less; - without a test."""
    if p is None:
        return "-"
    return f"{p:.1e}" if p < 0.001 else f"{p:.3f}"


def seconds(number: float) -> str:
    """Seconds, or milliseconds of what is less."""
    return f"{1e3 * number:.3g} ms" if number < 1 else f"{number:.3g} s"
