"""One number for each run, a row a way of doing it, beside the number that was published."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from springopt.report import style


@dataclass(frozen=True)
class Dots:
    """A panel: the numbers of each row's runs, and the published one."""

    label: str
    rows: Mapping[str, Sequence[float]]
    published: float | None = None
    log: bool = False


def draw_dots(panels: Sequence[Dots]) -> Figure:
    """Panels side by side that share their rows, from top to bottom."""
    rows = list(panels[0].rows)
    with rc_context(style.SETTINGS):
        size = (2.6 + 2.5 * len(panels), 0.8 + 0.24 * len(rows))
        figure = Figure(figsize=size, layout="constrained")
        all_axes = figure.subplots(1, len(panels), squeeze=False, sharey=True)[0]
        for axes, panel in zip(all_axes, panels, strict=True):
            _draw(axes, panel)
        all_axes[0].set_yticks(range(len(rows)), rows)
        all_axes[0].set_ylim(len(rows) - 0.5, -0.5)
    return figure


def _draw(axes: Axes, panel: Dots) -> None:
    for row, numbers in enumerate(panel.rows.values()):
        axes.plot(numbers, [row] * len(numbers), "o", color=style.MODEL, markersize=4.5, alpha=0.6, markeredgewidth=0)
    if panel.published is not None:
        axes.axvline(panel.published, color=style.REFERENCE, linewidth=1.2, zorder=0)
        axes.annotate(
            f"paper {panel.published:g}",
            (panel.published, 1.0),
            (3, 2),
            xycoords=("data", "axes fraction"),
            textcoords="offset points",
            color=style.REFERENCE,
        )
    if panel.log:
        axes.set_xscale("log")
    axes.grid(axis="y", color=style.REST, linewidth=0.4)
    axes.set_axisbelow(True)
    axes.tick_params(axis="y", length=0)
    axes.set_xlabel(panel.label)
