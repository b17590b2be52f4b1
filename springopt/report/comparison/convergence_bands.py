"""How the gap of every method fell on a scene: one panel each, with the others in grey behind it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import ceil
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator

from springopt.checks import Floats
from springopt.report import style
from springopt.report.comparison.method_lines import COLOURS
from springopt.report.comparison.said import SOLVED

MOST_COLUMNS = 6
WIDTH_OF_TITLE = 5.6  # inches
LOWEST = SOLVED / 2  # where a gap is drawn that is solved


def draw_bands(scene: Mapping[str, Any]) -> Figure:
    """Median and quartiles of the gap over the evaluations, for each method on the scene."""
    methods = scene["methods"]
    rows = ceil(len(methods) / MOST_COLUMNS)
    columns = ceil(len(methods) / rows)
    width, height = max(1.5 * columns + 0.65, WIDTH_OF_TITLE), 1.35 * rows + 0.75
    with rc_context(style.SETTINGS):
        figure = Figure(figsize=(width, height))
        title = f"{scene['scene']}: gap to the floor over the evaluations"
        figure.text(0.1 / width, 1 - 0.17 / height, title, fontsize=9.5, fontweight="bold", va="center")
        figure.supxlabel("evaluations", fontsize=8, y=0.05 / height, va="bottom")
        figure.supylabel("gap", fontsize=8, x=0.05 / width, ha="left")
        grid = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True).ravel()
        figure.subplots_adjust(0.6 / width, 0.45 / height, 1 - 0.05 / width, 1 - 0.55 / height, wspace=0.12, hspace=0.3)
        _scale(grid[0], methods)
        for axes, method in zip(grid, methods, strict=False):
            _draw_method(axes, method, methods)
        for axes in grid[len(methods) :]:
            axes.set_axis_off()
        for axes in grid[len(methods) - columns : len(methods)]:
            axes.tick_params(labelbottom=True)
        grid[0].text(0.98, 1.25, "start", fontsize=6, ha="right", transform=grid[0].get_yaxis_transform())
    return figure


def _draw_method(axes: Axes, method: Mapping[str, Any], methods: Sequence[Mapping[str, Any]]) -> None:
    others = [_steps(other["course"], "median") for other in methods]
    axes.add_collection(LineCollection(others, colors=style.REST, linewidths=0.5, zorder=1), autolim=False)
    course = method["course"]
    band = np.concatenate([_steps(course, "lower_quartile"), _steps(course, "upper_quartile")[::-1]])
    axes.fill(*band.T, color=COLOURS[0], alpha=0.3, linewidth=0, zorder=2)
    median = _steps(course, "median")
    axes.plot(*median.T, color=COLOURS[0], linewidth=1.3, zorder=3)
    axes.plot(*median[-1], "o", color=COLOURS[0], markersize=2.5, zorder=3, clip_on=False)
    axes.axhline(1.0, color=style.INK, linewidth=0.4, linestyle=(0, (4, 3)), zorder=0)
    axes.set_title(method["method"], loc="left", fontweight="bold", fontsize=7.5, pad=3)


def _steps(course: Mapping[str, Sequence[float]], name: str) -> Floats:
    """The corners of a line that holds each gap until the next, shape (corners, 2)."""
    evaluations, gaps = np.array(course["evaluations"]), np.maximum(course[name], LOWEST)
    return np.column_stack([np.repeat(evaluations, 2)[1:], np.repeat(gaps, 2)[:-1]])


def _scale(axes: Axes, methods: Sequence[Mapping[str, Any]]) -> None:
    """Both axes are logarithmic, and shared; below the last target all is solved."""
    highest = max(max(method["course"]["upper_quartile"]) for method in methods)
    most = max(method["course"]["evaluations"][-1] for method in methods)
    axes.set(xscale="log", yscale="log", xlim=(1, max(1.3 * most, 2)), ylim=(LOWEST / 1.3, max(2 * highest, 2)))
    axes.xaxis.set_major_locator(LogLocator(numticks=4))
    axes.yaxis.set_major_locator(LogLocator(numticks=6))
    axes.minorticks_off()
