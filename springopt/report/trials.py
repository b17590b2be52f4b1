"""Trials beside each other: the distribution of stiffness in each, and how far they differ spring by spring."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from springopt.checks import Floats
from springopt.encoding.spring_classes import SpringClasses
from springopt.report import style
from springopt.report.style import plain_ticks

STEP = 0.5  # of stiffness


@dataclass(frozen=True, eq=False)
class Trials:
    """A row: the stiffness of each trial, and the spread of all seeds beside the standard errors."""

    label: str
    stiffness: Mapping[str, Floats]  #: by trial, shape (s,) each
    spread: Floats  #: of each spring over the seeds, shape (s,)
    standard_errors: Floats  #: inf where a spring is not identified, shape (s,)


def draw_trials(rows: Sequence[Trials], classes: SpringClasses, peaks: Sequence[tuple[float, float]]) -> Figure:
    """A histogram for each trial, its classes stacked over the published intervals, then the spread of each spring."""
    columns = len(rows[0].stiffness) + 1
    with rc_context(style.SETTINGS):
        figure = Figure(figsize=(2.2 * columns + 0.4, 2.3 * len(rows) + 0.3), layout="constrained")
        grid = figure.subplots(len(rows), columns, squeeze=False)
        for line, row in zip(grid, rows, strict=True):
            top = max(_counts(stiffness).max() for stiffness in row.stiffness.values())
            for axes, (name, stiffness) in zip(line, row.stiffness.items(), strict=False):
                _draw_histogram(axes, stiffness, classes, peaks)
                axes.set(title=name, ylim=(0, 1.08 * top))
            _draw_spread(line[-1], row, classes)
            line[0].set_ylabel(f"{row.label}\nsprings")
        for axes in grid[-1, :-1]:
            axes.set_xlabel("stiffness")
        handles, labels = grid[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=len(labels), **style.LEGEND)
    return figure


def _counts(stiffness: Floats) -> Floats:
    return np.histogram(stiffness, _edges())[0].astype(float)


def _edges() -> Floats:
    return np.arange(0.0, 10.0 + STEP, STEP)


def _draw_histogram(
    axes: Axes, stiffness: Floats, classes: SpringClasses, peaks: Sequence[tuple[float, float]]
) -> None:
    for low, high in peaks:
        axes.axvspan(low, high, color=style.REST, alpha=0.45, linewidth=0)
    axes.hist(
        [stiffness[mask] for mask in classes.values()],
        bins=_edges().tolist(),
        stacked=True,
        color=[style.CLASS_COLOURS[name] for name in classes],
        edgecolor="white",
        linewidth=0.4,
        label=list(classes),
    )


def _draw_spread(axes: Axes, row: Trials, classes: SpringClasses) -> None:
    """Springs that are not identified lie at the right edge."""
    finite = np.isfinite(row.standard_errors)
    edge = 2 * row.standard_errors[finite].max()
    errors, spread = np.where(finite, row.standard_errors, edge), np.maximum(row.spread, 1e-3)
    for name, mask in classes.items():
        for chosen, look in ((mask & finite, "o"), (mask & ~finite, "D")):
            axes.plot(errors[chosen], spread[chosen], look, color=style.CLASS_COLOURS[name], markersize=3.5, alpha=0.7)
    axes.set(xscale="log", yscale="log", xlabel="standard error", ylabel="spread over the seeds")
    axes.set_title("Spring by spring")
    plain_ticks(axes.xaxis)
    plain_ticks(axes.yaxis)
    if not finite.all():
        axes.annotate("unseen", (edge, 0.02), xycoords=("data", "axes fraction"), rotation=90, ha="center")
