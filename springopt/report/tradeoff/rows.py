"""The table of an axis, as heads and rows of words: for the terminal and for the page alike."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from springopt.report.tradeoff.said import say_error, say_number, say_point, say_seconds, say_time

NAMES = 2  # of the columns are names, to the left
TEXTS = 1  # at the end may wrap


def heads(axis: Mapping[str, Any]) -> tuple[str, ...]:
    """The columns: series, setting, error, times, what the axis shows beside them, and words."""
    numbers = (name.replace("_", " ") for name in axis["shown"])
    second = (axis["second_time"],) if axis["second_time"] else ()
    return ("series", "setting", "error", "processor time", "wall time", "warm-up", "repeats", *second, *numbers, "")


def rows(axis: Mapping[str, Any]) -> Iterator[tuple[str, ...]]:
    """A row a setting."""
    for point in axis["points"]:
        yield (
            point["series"],
            point["setting"],
            say_error(point["error"]),
            say_time(point["processor_seconds"]),
            say_seconds(point["wall_seconds"]["value"]),
            say_seconds(point["warm_up_seconds"]),
            str(point["repeats"]),
            *((say_time(point["second_seconds"]) if point["second_seconds"] else "-",) if axis["second_time"] else ()),
            *(say_number(point["numbers"].get(name)) for name in axis["shown"]),
            say_point(point),
        )


def sentences(axis: Mapping[str, Any]) -> list[str]:
    """What an axis comes to, the price of a digit first."""
    said = []
    if axis["price_of_a_digit"]:
        said.append(f"Along the front {axis['price_of_a_digit']['said']}.")
    of_series = {name: price for name, price in axis["prices_of_a_digit"].items() if price}
    if len({point["series"] for point in axis["points"]}) > 1:
        said += [f"{name}: {price['said']}." for name, price in of_series.items()]
    return said + list(axis["notes"])
