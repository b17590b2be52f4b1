"""Work-precision diagrams: log error over log time, with the intervals of both, and the Pareto front."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import ceil
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from springopt.report import style

MARKERS = ("o", "s", "^", "D", "v", "P", "X", "<", ">", "*")
LEGEND_COLUMNS = 3
MOST_LABELS = 14  # points whose settings are written beside them
LABEL_LENGTH = 24


def draw_tradeoff(axis: Mapping[str, Any]) -> Figure:
    """One axis of a tradeoff, as the document has it."""
    series = list(dict.fromkeys(point["series"] for point in axis["points"]))
    legend_rows = ceil((len(series) + 3) / LEGEND_COLUMNS)
    with rc_context(style.SETTINGS):
        figure = Figure(figsize=(6.4, 3.6 + 0.19 * legend_rows), layout="constrained")
        axes = figure.subplots()
        bottom = _bottom(axis["points"])
        for number, name in enumerate(series):
            of_series = [point for point in axis["points"] if point["series"] == name]
            colour = style.SERIES[number % len(style.SERIES)]
            marker = MARKERS[(number // len(style.SERIES) + number) % len(MARKERS)]
            _draw_series(axes, name, of_series, bottom, colour, marker)
        _draw_front(axes, axis["points"], bottom)
        axes.set(
            xscale="log", yscale="log", xlabel=f"processor time of {axis['time']} [s]", ylabel=_label(axis["error"])
        )
        _draw_failures(axes, axis["points"], series)
        _draw_marks(axes, axis["marks"])
        if len(axis["points"]) <= MOST_LABELS:
            _name_points(axes, axis["points"], bottom)
        price = axis["price_of_a_digit"]
        axes.set_title(axis["title"], loc="left", fontweight="bold")
        if price:
            axes.set_title(price["said"], loc="right", fontsize=7.5)
        axes.grid(color=style.REST, linewidth=0.3)
        axes.set_axisbelow(True)
        figure.legend(loc="outside lower center", ncols=LEGEND_COLUMNS, **style.LEGEND)
    return figure


def _draw_series(
    axes: Axes, name: str, points: Sequence[Mapping[str, Any]], bottom: float, colour: str, marker: str
) -> None:
    """The points of a series in their order, joined; hollow where some answers are none."""
    found = [point for point in points if point["error"]]
    if not found:
        axes.plot([], [], color=colour, marker=marker, markersize=4, linewidth=0.9, label=name)
        return
    times, time_bars = _bars([point["processor_seconds"] for point in found], 0.0)
    errors, error_bars = _bars([point["error"] for point in found], bottom)
    axes.errorbar(
        times,
        errors,
        yerr=error_bars,
        xerr=time_bars,
        color=colour,
        linewidth=0.9,
        elinewidth=0.6,
        label=name,
        zorder=3,
    )
    for time, error, point in zip(times, errors, found, strict=True):
        face = "white" if point["failures"] else colour
        axes.plot(time, error, marker, color=colour, markersize=4, markerfacecolor=face, zorder=4)
        if point["is_stated"]:
            axes.plot(time, error, "o", markersize=9, markerfacecolor="none", color=style.INK, zorder=5)


def _draw_front(axes: Axes, points: Sequence[Mapping[str, Any]], bottom: float) -> None:
    front = sorted((p for p in points if p["on_front"]), key=lambda point: point["processor_seconds"]["value"])
    if front:
        times = [point["processor_seconds"]["value"] for point in front]
        errors = [max(point["error"]["value"], bottom) for point in front]
        axes.step(times, errors, where="post", color=style.REST, linewidth=4, alpha=0.6, label="Pareto front", zorder=1)
    if any(point["is_stated"] for point in points):
        ring: Any = {"markersize": 8, "markerfacecolor": "none", "linestyle": "none", "color": style.INK}
        axes.plot([], [], marker="o", label="as the scene states it", **ring)


def _draw_failures(axes: Axes, points: Sequence[Mapping[str, Any]], series: Sequence[str]) -> None:
    """Settings without any answer lie at the upper edge, at the time that they took."""
    failed = [point for point in points if not point["error"]]
    if not failed:
        return
    times = [point["processor_seconds"]["value"] for point in failed]
    colours = [style.SERIES[series.index(point["series"]) % len(style.SERIES)] for point in failed]
    transform = axes.get_xaxis_transform()
    axes.scatter(times, [0.985] * len(times), c=colours, marker="x", transform=transform, s=28, clip_on=False, zorder=6)
    axes.plot([], [], "x", color=style.INK, label="no answer")


def _draw_marks(axes: Axes, marks: Mapping[str, float]) -> None:
    for words, time in marks.items():
        axes.axvline(time, color=style.REFERENCE, linewidth=0.9, linestyle="--", zorder=2)
        axes.annotate(
            words,
            (time, 0.02),
            (3, 0),
            xycoords=("data", "axes fraction"),
            textcoords="offset points",
            rotation=90,
            fontsize=6.5,
            color=style.REFERENCE,
        )


def _name_points(axes: Axes, points: Sequence[Mapping[str, Any]], bottom: float) -> None:
    for point in points:
        if point["error"] and len(point["setting"]) <= LABEL_LENGTH:
            place = (point["processor_seconds"]["value"], max(point["error"]["value"], bottom))
            axes.annotate(point["setting"], place, (5, 3), textcoords="offset points", fontsize=6, color=style.INK)


def _bars(intervals: Sequence[Mapping[str, float]], bottom: float) -> tuple[Any, Any]:
    """Middles, and the bars below and above them, shape (2, points)."""
    value, low, high = (np.maximum([each[name] for each in intervals], bottom) for name in ("value", "low", "high"))
    return value, np.array([value - low, high - value])


def _bottom(points: Sequence[Mapping[str, Any]]) -> float:
    """Where the log scale shows an error of zero."""
    return style.bottom(np.array([point["error"]["low"] for point in points if point["error"]], dtype=float))


def _label(words: str) -> str:
    return words[0].upper() + words[1:]
