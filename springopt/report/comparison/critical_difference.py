"""Mean ranks on a line, with bars over those that do not differ (Demsar 2006, Figure 1)."""

from __future__ import annotations

from collections.abc import Mapping
from math import ceil, floor
from typing import Any

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from springopt.report import style
from springopt.report.comparison import said

WIDTH = 7.0  # inches
STEP = 0.17  # inches between two names
BAR = 0.09  # inches between two bars
AXIS = 0.62  # inches from the top to the line


def draw_critical_difference(ranking: Mapping[str, Any]) -> Figure:
    """The best rank on the left; names of the better half on the left, of the others on the right."""
    ranks: Mapping[str, float] = ranking["mean_ranks"]
    bars = groups(list(ranks.values()), ranking["critical_difference"])
    first = AXIS + 0.16 + BAR * len(bars) + 0.12
    height = first + STEP * ceil(len(ranks) / 2) + 0.1
    with rc_context(style.SETTINGS):
        figure = Figure(figsize=(WIDTH, height))
        axes = figure.add_axes((0, 0, 1, 1))
        axes.set_axis_off()
        axes.set(xlim=(0, WIDTH), ylim=(height, 0))
        place = _draw_axis(axes, ranks, ranking["critical_difference"])
        axes.text(0.1, 0.14, _title(ranking), fontsize=9.5, fontweight="bold", va="center")
        _draw_names(axes, ranks, place, first)
        for i, (low, high) in enumerate(bars):
            level = AXIS + 0.16 + BAR * i
            axes.plot([place(low) - 0.04, place(high) + 0.04], [level, level], color=style.INK, linewidth=2.6)
    return figure


def groups(ranks: list[float], difference: float) -> list[tuple[float, float]]:
    """First and last rank of each longest row of neighbours that lie within the critical difference; ranks rise."""
    rows: list[tuple[int, int]] = []
    for i, low in enumerate(ranks):
        last = max(j for j, rank in enumerate(ranks) if rank - low < difference)
        if last > i and (not rows or last > rows[-1][1]):
            rows.append((i, last))
    return [(ranks[i], ranks[j]) for i, j in rows]


class _Place:
    """Where a rank lies on the line, in inches."""

    def __init__(self, ranks: Mapping[str, float], margin: float) -> None:
        self.low, self.high = floor(min(ranks.values())), max(ceil(max(ranks.values())), floor(min(ranks.values())) + 1)
        self.margin = margin

    def __call__(self, rank: float) -> float:
        return self.margin + (rank - self.low) / (self.high - self.low) * (WIDTH - 2 * self.margin)


def _draw_axis(axes: Axes, ranks: Mapping[str, float], difference: float) -> _Place:
    place = _Place(ranks, 0.075 * max(map(len, ranks)) + 0.45)
    axes.plot([place(place.low), place(place.high)], [AXIS, AXIS], color=style.INK, linewidth=0.8)
    for rank in range(place.low, place.high + 1):
        axes.plot([place(rank)] * 2, [AXIS, AXIS - 0.06], color=style.INK, linewidth=0.8)
        axes.text(place(rank), AXIS - 0.09, str(rank), ha="center", va="bottom", fontsize=7.5)
    end = place(place.low + difference)
    if end <= WIDTH:
        axes.plot([place(place.low), end], [AXIS - 0.29] * 2, color=style.REFERENCE, linewidth=1.2)
        for x in (place(place.low), end):
            axes.plot([x, x], [AXIS - 0.32, AXIS - 0.26], color=style.REFERENCE, linewidth=1.2)
    text = f"critical difference {difference:.2f}"
    axes.text(min(end, WIDTH - 1.4) + 0.06, AXIS - 0.29, text, fontsize=7.5, va="center", color=style.REFERENCE)
    return place


def _draw_names(axes: Axes, ranks: Mapping[str, float], place: _Place, first: float) -> None:
    """Lines down from the ranks, and out to the names; on the right the worst is the highest."""
    names = list(ranks)
    half = ceil(len(names) / 2)
    for i, name in enumerate(names):
        left = i < half
        level = first + STEP * (i if left else len(names) - 1 - i)
        x, edge = place(ranks[name]), place(place.low) - 0.1 if left else place(place.high) + 0.1
        axes.plot([x, x, edge], [AXIS, level, level], color=style.INK, linewidth=0.6)
        text = f"{name}  {ranks[name]:.2f}" if left else f"{ranks[name]:.2f}  {name}"
        axes.text(
            edge + (-0.05 if left else 0.05), level, text, ha="right" if left else "left", va="center", fontsize=7.5
        )


def _title(ranking: Mapping[str, Any]) -> str:
    friedman = ranking["friedman"]
    title = f"Mean ranks over {len(ranking['scenes'])} scenes"
    return f"{title}; Friedman p {said.p_value(friedman['p'])}, W {friedman['kendall_w']:.2f}" if friedman else title
