"""The share of problems that methods solve, over budgets or over factors of the best method's time, in each unit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import PercentFormatter

from springopt.report import style
from springopt.report.comparison.method_lines import LINE_HEIGHT, looks, name_ends
from springopt.report.comparison.said import UNITS

Curves = Mapping[str, Any]


def draw_over_budget(
    curves: Sequence[Curves], methods: Sequence[str], served: Mapping[str, int], scenes: int
) -> Figure:
    """Empirical distributions of running times to all targets; one panel a unit.

    Args:
        served: method -> on how many scenes it has runs.
        scenes: how many there are.
    """
    title = f"Targets reached within a budget: {scenes} scenes, 6 targets each, all runs"
    return _draw(title, curves, methods, {unit: f"{name} spent" for unit, name in UNITS.items()}, served, scenes)


def draw_profiles(curves: Sequence[Curves], methods: Sequence[str], served: Mapping[str, int], scenes: int) -> Figure:
    """Performance profiles over all scenes and targets; one panel a unit."""
    title = "Performance profiles: targets reached within a factor of the fastest optimizer's time"
    axis = {unit: f"expected {name} over the fastest optimizer's" for unit, name in UNITS.items()}
    return _draw(title, curves, methods, axis, served, scenes)


def _draw(
    title: str,
    curves: Sequence[Curves],
    methods: Sequence[str],
    axis: Mapping[str, str],
    served: Mapping[str, int],
    scenes: int,
) -> Figure:
    height = max(2.1, (len(methods) + 1) * LINE_HEIGHT / 72)
    names = {
        method: method if served[method] == scenes else f"{method} ({served[method]} of {scenes} scenes)"
        for method in methods
    }
    with rc_context(style.SETTINGS):
        figure = Figure(figsize=(7.2, len(curves) * (height + 0.55) + 0.45))
        figure.suptitle(title, fontsize=9.5, fontweight="bold", x=0.02, ha="left", y=1 - 0.1 / figure.get_figheight())
        figure.subplots_adjust(
            left=0.08,
            right=0.64,
            bottom=0.45 / figure.get_figheight(),
            top=1 - 0.4 / figure.get_figheight(),
            hspace=0.55 / height,
        )
        for axes, panel in zip(figure.subplots(len(curves), 1, squeeze=False)[:, 0], curves, strict=True):
            _draw_panel(axes, panel, methods, names)
            axes.set_xlabel(axis[panel["unit"]])
    return figure


def _draw_panel(axes: Axes, panel: Curves, methods: Sequence[str], names: Mapping[str, str]) -> None:
    places, look = np.array(panel["places"]), looks(methods)
    top = max(max(panel["shares"][method]) for method in methods)
    axes.set(xscale="log", xlim=(places[0], 1.15 * places[-1]), ylim=(0, max(1.04 * top, 0.01)))
    for method in methods:
        shares = panel["shares"][method]
        axes.step([*places, 1.15 * places[-1]], [*shares, shares[-1]], where="post", linewidth=1.1, **look[method])
    axes.yaxis.set_major_formatter(PercentFormatter(1, decimals=0))
    axes.grid(axis="y", color=style.REST, linewidth=0.4)
    ends = {names[method]: panel["shares"][method][-1] for method in methods}
    name_ends(axes, ends, {names[method]: look[method] for method in methods})
