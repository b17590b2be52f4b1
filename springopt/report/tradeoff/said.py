"""Numbers of a tradeoff in words."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

Interval = Mapping[str, float]

_UNITS = ((1.0, "s"), (1e-3, "ms"), (1e-6, "µs"), (1e-9, "ns"))


def say_seconds(seconds: float) -> str:
    """As in "3.1 ms"."""
    factor, unit = next((pair for pair in _UNITS if seconds >= pair[0]), _UNITS[-1])
    return f"{seconds / factor:.3g} {unit}"


def say_time(interval: Interval) -> str:
    """As in "3.1 ms (3.0 to 3.3)"."""
    value, low, high = (interval[name] for name in ("value", "low", "high"))
    factor, unit = next((pair for pair in _UNITS if value >= pair[0]), _UNITS[-1])
    return f"{value / factor:.3g} {unit} ({low / factor:.3g} to {high / factor:.3g})"


def say_error(interval: Interval | None) -> str:
    """As in "1.2e-04 (1.1e-04 to 1.4e-04)"; a dash where there is no answer at all."""
    if interval is None:
        return "-"
    value, low, high = (f"{interval[name]:.2g}" for name in ("value", "low", "high"))
    return value if value == low == high else f"{value} ({low} to {high})"


def say_point(point: Mapping[str, Any]) -> str:
    """What is special about it."""
    said = []
    if point["is_stated"]:
        said.append("as stated")
    if point["on_front"]:
        said.append("front")
    if point["failures"]:
        said.append(
            f"{point['failures']} of {point['answers']} failed" + (f" ({point['why']})" if point["why"] else "")
        )
    if point["is_apart"]:
        said.append("judged apart")
    return ", ".join(said)


def say_number(number: Any) -> str:
    """Any of the numbers that an axis shows."""
    if number is None:
        return "-"
    if isinstance(number, bool | str):
        return str(number)
    return f"{number:,}" if isinstance(number, int) else f"{number:,.4g}"
