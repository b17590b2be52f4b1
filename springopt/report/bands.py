"""How several ways converge: the median of their runs and what lies between the best and the worst."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from springopt.checks import Floats
from springopt.report import style

#: A log scale ends at this share of the largest value; what is below, zero too, lies at its bottom.
RANGE = 1e-4


def draw_bands(curves: Mapping[str, Floats], *, xlabel: str, ylabel: str, early: int) -> Figure:
    """Two panels, the first `early` steps on plain scales and all of them on a log scale.

    Args:
        curves: by name, a value for each run and step, shape (runs, steps).
    """
    with rc_context(style.SETTINGS):
        figure = Figure(figsize=(7.6, 3.0), layout="constrained")
        beginning, whole = figure.subplots(1, 2)
        _draw(beginning, {name: curve[:, :early] for name, curve in curves.items()}, 0.0)
        top = max(float(curve.max()) for curve in curves.values())
        _draw(whole, curves, RANGE * top)
        beginning.set(xlabel=xlabel, ylabel=ylabel, ylim=(0, None), xlim=(0, early))
        beginning.set_title("At first", loc="left", fontweight="bold")
        whole.set(xlabel=xlabel, yscale="log", ylim=(RANGE * top, 1.3 * top), xlim=(0, None))
        whole.set_title("In the end", loc="left", fontweight="bold")
        beginning.legend(title="pmut(g)", loc="upper right")
    return figure


def _draw(axes: Axes, curves: Mapping[str, Floats], bottom: float) -> None:
    for (name, curve), colour in zip(curves.items(), style.SERIES, strict=False):
        steps = np.arange(1, curve.shape[1] + 1)
        shown = np.maximum(curve, bottom)
        axes.fill_between(steps, shown.min(axis=0), shown.max(axis=0), color=colour, alpha=0.15, linewidth=0)
        axes.plot(steps, np.median(shown, axis=0), color=colour, linewidth=1.4, label=name)
