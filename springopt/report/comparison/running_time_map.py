"""Expected running times of every method on every scene, as a map; where there is none, why."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib import colormaps, rc_context
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure

from springopt.report import style
from springopt.report.comparison import said
from springopt.report.comparison.said import UNITS

COLOURS = colormaps["cividis"]
NORM = LogNorm(1, 1000)
ABSENT = "#F0F0F0"

Cells = Mapping[tuple[str, str], tuple[str, float | None]]


def draw_running_times(comparison: Mapping[str, Any]) -> Figure:
    """One map a unit: the expected running time to the target, coloured by how many times the fastest one it is."""
    methods = [each["method"] for each in comparison["methods"]]
    methods += sorted({each["method"] for each in comparison["refusals"]} - set(methods))
    scenes = [each["scene"] for each in comparison["scenes"]]
    width, height = 0.42 * len(scenes), 0.17 * len(methods)
    names, below = 0.062 * max(map(len, methods)) + 0.15, 0.045 * max(map(len, scenes)) + 0.25
    with rc_context(style.SETTINGS):
        size = max(width, 3.2) + names + 0.9, len(UNITS) * (height + 0.35) + below + 0.5
        figure = Figure(figsize=size, layout="constrained")
        target = said.power(comparison["target"])
        figure.suptitle(f"Expected running time to {target} of the way", fontsize=9.5, fontweight="bold")
        panels = figure.subplots(len(UNITS), 1, sharex=True, squeeze=False)[:, 0]
        for axes, (unit, name) in zip(panels, UNITS.items(), strict=True):
            _draw_map(axes, methods, scenes, _cells(comparison, unit))
            axes.set_title(name, loc="left", fontweight="bold")
        panels[-1].set_xticks(range(len(scenes)), scenes, rotation=40, ha="right", rotation_mode="anchor")
        bar = figure.colorbar(ScalarMappable(NORM, COLOURS), ax=panels, shrink=0.5, extend="max", pad=0.02)
        bar.set_label("times the fastest optimizer's")
    return figure


def _cells(comparison: Mapping[str, Any], unit: str) -> dict[tuple[str, str], tuple[str, float | None]]:
    """(method, scene) -> what is written there, and the running time over the least of the scene, None without one."""
    cells: dict[tuple[str, str], tuple[str, float | None]] = {
        (each["method"], each["scene"]): (each["word"], None) for each in comparison["refusals"]
    }
    for scene in comparison["scenes"]:
        times = {
            each["method"]: each["targets"][comparison["target"]]["running_times"][unit]["value"]
            for each in scene["methods"]
        }
        best = min(times.values())
        for method, time in times.items():
            solved = math.isfinite(time)
            cells[method, scene["scene"]] = (said.brief(time), time / best) if solved else ("never", None)
    return cells


def _draw_map(axes: Axes, methods: Sequence[str], scenes: Sequence[str], cells: Cells) -> None:
    ratios = np.array([[cells.get((method, scene), ("", None))[1] or np.nan for scene in scenes] for method in methods])
    axes.imshow(np.ma.masked_invalid(ratios), cmap=COLOURS, norm=NORM, aspect="auto")
    axes.set_facecolor(ABSENT)
    axes.set_yticks(range(len(methods)), methods)
    axes.tick_params(length=0)
    axes.spines[:].set_visible(False)
    for edge in np.arange(len(scenes) - 1) + 0.5:
        axes.axvline(edge, color="white", linewidth=1)
    for edge in np.arange(len(methods) - 1) + 0.5:
        axes.axhline(edge, color="white", linewidth=1)
    for row, method in enumerate(methods):
        for column, scene in enumerate(scenes):
            text, ratio = cells.get((method, scene), ("-", None))
            _write(axes, column, row, text, ratio)


def _write(axes: Axes, column: int, row: int, text: str, ratio: float | None) -> None:
    """Dark on light colours, light on dark ones; grey and slanted where there is no number."""
    if ratio is None:
        axes.text(column, row, text, ha="center", va="center", fontsize=5.6, color="#777777", style="italic")
        return
    colour = "black" if float(Normalize(0, 1)(NORM(ratio))) > 0.5 else "white"
    axes.text(column, row, text, ha="center", va="center", fontsize=6.4, color=colour)
