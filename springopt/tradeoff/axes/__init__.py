"""The axes, one a module each; a module is imported when its axis is asked for."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module

from springopt.errors import UserError, did_you_mean
from springopt.tradeoff.point import Axis

#: In the order in which they are measured, the quick ones first.
MODULES = {
    "solver": "solver",
    "effects": "effects",
    "stepping": "stepping",
    "reference": "reference",
    "model": "model",
    "load-cases": "load_cases",
    "optimizer": "optimizer",
}


def choose_axes(names: Sequence[str] = ()) -> list[Axis]:
    """The axes of these names, in their order; all of them without names."""
    for name in names:
        if name not in MODULES:
            raise UserError(f"there is no axis {name!r}; there are {', '.join(MODULES)}.{did_you_mean(name, MODULES)}")
    return [
        import_module(f"springopt.tradeoff.axes.{module}").AXIS
        for name, module in MODULES.items()
        if name in names or not names
    ]
