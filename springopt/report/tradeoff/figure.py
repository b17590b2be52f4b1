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
LEGEND_WIDTH = 1.9  # inches of a column
MOST_LABELS = 14  # points whose settings are written beside them
LABEL_LENGTH = 24
ROUNDING = 1e-16  # of an error on a relative scale: what is smaller is shown here
_MARK: Any = {
    "xycoords": ("data", "axes fraction"),
    "textcoords": "offset points",
    "rotation": 90,
    "fontsize": 6.5,
    "color": style.REFERENCE,
}
_LINES: Any = {"linewidth": 0.9, "elinewidth": 0.6, "markersize": 4, "zorder": 3}


def draw_tradeoff(axis: Mapping[str, Any]) -> Figure:
    """One axis of a tradeoff, as the document has it; beside it a second diagram where it has a second time."""
    points, label = axis["points"], "processor time of {} [s]"
    series = list(dict.fromkeys(point["series"] for point in points))
    panels = [([point | {"time": point["processor_seconds"]} for point in points], label.format(axis["time"]))]
    if axis["second_time"]:
        known = [point | {"time": point["second_seconds"]} for point in points if point["second_seconds"]]
        panels.append((known, label.format(axis["second_time"])))
    width = 6.4 if len(panels) == 1 else 9.6
    columns = int(width / LEGEND_WIDTH)
    height = 3.6 + 0.19 * ceil((len(series) + 3) / columns)
    with rc_context(style.SETTINGS):
        figure = Figure(figsize=(width, height), layout="constrained")
        all_axes = figure.subplots(1, len(panels), sharey=True, squeeze=False)[0]
        for axes, (shown, xlabel) in zip(all_axes, panels, strict=True):
            _draw_panel(axes, axis, shown, series)
            axes.set_xlabel(xlabel)
        _draw_marks(all_axes[-1], axis["marks"])
        all_axes[0].set_ylabel(_label(axis["error"]))
        _draw_titles(all_axes[0], axis)
        handles = {
            name: handle for axes in all_axes for handle, name in zip(*axes.get_legend_handles_labels(), strict=True)
        }
        figure.legend(handles.values(), handles, loc="outside lower center", ncols=columns, **style.LEGEND)
    return figure


def _draw_panel(
    axes: Axes, axis: Mapping[str, Any], points: Sequence[Mapping[str, Any]], series: Sequence[str]
) -> None:
    """Points with the "time" that this panel shows."""
    bottom = _bottom(points)
    for number, name in enumerate(series):
        of_series = [point for point in points if point["series"] == name]
        colour = style.SERIES[number % len(style.SERIES)]
        marker = MARKERS[(number // len(style.SERIES) + number) % len(MARKERS)]
        if of_series:
            _draw_series(axes, name, of_series, bottom, fmt=f"{marker}{_line(axis, of_series)}", color=colour)
    _draw_front(axes, points, bottom)
    # Without any error there is nothing to be on a logarithmic scale, which is an error when it is drawn.
    axes.set(xscale="log", yscale="log" if any(point["error"] for point in points) else "linear")
    _show_all_times(axes, points)
    _draw_failures(axes, points, series)
    _name_points(axes, points, bottom)
    axes.grid(color=style.REST, linewidth=0.3)
    axes.set_axisbelow(True)


def _line(axis: Mapping[str, Any], points: Sequence[Mapping[str, Any]]) -> str:
    """Joined where settings are graded; dotted where another truth judges them."""
    if not axis["is_graded"]:
        return ""
    return ":" if points[0]["is_apart"] else "-"


def _draw_series(
    axes: Axes, name: str, points: Sequence[Mapping[str, Any]], bottom: float, *, fmt: str, color: str
) -> None:
    """The points of a series in their order, joined where they are graded; hollow where some answers are none."""
    found = [point for point in points if point["error"]]
    times, time_bars = _bars([point["time"] for point in found], 0.0)
    errors, error_bars = _bars([point["error"] for point in found], bottom)
    axes.errorbar(times, errors, yerr=error_bars, xerr=time_bars, fmt=fmt, color=color, label=name, **_LINES)
    for time, error, point in zip(times, errors, found, strict=True):
        if point["failures"]:
            axes.plot(time, error, fmt[0], color=color, markersize=4, markerfacecolor="white", zorder=4)
        if point["is_stated"]:
            axes.plot(time, error, "o", markersize=9, markerfacecolor="none", color=style.INK, zorder=5)


def _draw_front(axes: Axes, points: Sequence[Mapping[str, Any]], bottom: float) -> None:
    front = sorted((p for p in points if p["on_front"]), key=lambda point: point["time"]["value"])
    if front:
        times = [point["time"]["value"] for point in front]
        errors = [max(point["error"]["value"], bottom) for point in front]
        axes.step(times, errors, where="post", color=style.REST, linewidth=4, alpha=0.6, label="Pareto front", zorder=1)
    if any(point["is_stated"] for point in points):
        ring: Any = {"markersize": 8, "markerfacecolor": "none", "linestyle": "none", "color": style.INK}
        axes.plot([], [], marker="o", label="as the scene states it", **ring)


def _show_all_times(axes: Axes, points: Sequence[Mapping[str, Any]]) -> None:
    """Those of settings without an answer too."""
    times = [point["time"][end] for point in points for end in ("low", "high") if point["time"][end] > 0.0]
    if times:
        axes.set_xlim(min(times) / 1.5, 1.5 * max(times))


def _draw_failures(axes: Axes, points: Sequence[Mapping[str, Any]], series: Sequence[str]) -> None:
    """Settings without any answer lie at the upper edge, at the time that they took."""
    failed = [point for point in points if not point["error"]]
    if not failed:
        return
    times = [point["time"]["value"] for point in failed]
    colours = [style.SERIES[series.index(point["series"]) % len(style.SERIES)] for point in failed]
    transform = axes.get_xaxis_transform()
    axes.scatter(times, [0.985] * len(times), c=colours, marker="x", transform=transform, s=28, clip_on=False, zorder=6)
    axes.plot([], [], "x", color=style.INK, label="no answer")


def _draw_marks(axes: Axes, marks: Mapping[str, float]) -> None:
    if marks:
        low, high = axes.get_xlim()
        axes.set_xlim(
            min(low, *(time / 1.5 for time in marks.values())), max(high, *(1.5 * time for time in marks.values()))
        )
    for words, time in marks.items():
        axes.axvline(time, color=style.REFERENCE, linewidth=0.9, linestyle="--", zorder=2)
        axes.annotate(words, (time, 0.02), (3, 0), **_MARK)


def _draw_titles(axes: Axes, axis: Mapping[str, Any]) -> None:
    """The axis, and below it the price of a digit."""
    price = axis["price_of_a_digit"]
    axes.set_title(axis["title"], loc="left", fontweight="bold", pad=16 if price else 6)
    if price:
        axes.annotate(price["said"], (0, 1), (0, 5), xycoords="axes fraction", textcoords="offset points")


def _name_points(axes: Axes, points: Sequence[Mapping[str, Any]], bottom: float) -> None:
    """The settings beside their points; of many those of the front alone."""
    for point in points:
        is_named = len(points) <= MOST_LABELS or point["on_front"]
        if is_named and point["error"] and len(point["setting"]) <= LABEL_LENGTH:
            place = (point["time"]["value"], max(point["error"]["value"], bottom))
            axes.annotate(point["setting"], place, (5, 3), textcoords="offset points", fontsize=6, color=style.INK)


def _bars(intervals: Sequence[Mapping[str, float]], bottom: float) -> tuple[Any, Any]:
    """Middles, and the bars below and above them, shape (2, points)."""
    table = np.array([[each[name] for name in ("value", "low", "high")] for each in intervals]).reshape(-1, 3)
    value, low, high = np.maximum(table, bottom).T
    return value, np.array([value - low, high - value])


def _bottom(points: Sequence[Mapping[str, Any]]) -> float:
    """Where the log scale shows an error of zero."""
    least = style.bottom(np.array([point["error"]["value"] for point in points if point["error"]], dtype=float))
    return max(least, ROUNDING)


def _label(words: str) -> str:
    return words[0].upper() + words[1:]
