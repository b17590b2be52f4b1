"""The lattice coloured by how well each spring is identified, and the standard errors in order."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib import colormaps, rc_context
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from springopt.checks import Booleans, Floats
from springopt.lattice import SpringLattice
from springopt.report import style
from springopt.report.body import project

COLOURS = colormaps["viridis_r"]
UNSEEN, SHARED = style.MODEL, "#CC79A7"
LABEL = "standard error of the stiffness"
LOOKS = {"unseen": (UNSEEN, (0, (3.5, 1.2))), "shared": (SHARED, (0, (1.0, 0.8)))}


@dataclass(frozen=True, eq=False)
class Identified:
    """What the figure shows."""

    title: str
    lattice: SpringLattice
    standard_errors: Floats  #: inf where a spring is not identified, shape (s,)
    is_seen: Booleans  #: shape (s,)


def draw_identified(identified: Identified) -> Figure:
    """The lattice to the left, its springs coloured on a log scale; the sorted errors to the right."""
    low, high = _limits(project(identified.lattice.nodes))
    aspect = (high[1] - low[1]) / (high[0] - low[0])
    norm = _norm(identified.standard_errors)
    with rc_context(style.SETTINGS):
        height = float(np.clip(4.2 * aspect, 2.4, 4.6))
        figure = Figure(figsize=(7.6, height + 0.9), layout="constrained")
        figure.suptitle(identified.title, fontsize=9.5, fontweight="bold")
        left, right = figure.subplots(1, 2, width_ratios=[1.45, 1.0])
        _draw_lattice(left, identified, norm)
        left.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
        if np.isfinite(identified.standard_errors).any():
            bar = figure.colorbar(ScalarMappable(norm, COLOURS), ax=left, label=LABEL, shrink=0.85, pad=0.02)
            style.plain_ticks(bar.ax.yaxis)
        _draw_order(right, identified, norm)
        if handles := _legend(identified):
            figure.legend(handles=handles, loc="outside lower center", ncols=2, **style.LEGEND)
    return figure


def _draw_lattice(axes: Axes, identified: Identified, norm: LogNorm) -> None:
    nodes, springs, errors = project(identified.lattice.nodes), identified.lattice.springs, identified.standard_errors
    finite = np.isfinite(errors)
    order = np.flatnonzero(finite)[np.argsort(errors[finite], kind="stable")]  # the worst ones on top
    depth = 1.0 if identified.lattice.dimension == 2 else 0.4
    widths = depth * (1.2 + 2.4 * norm(errors[order]).data)
    axes.add_collection(LineCollection(list(nodes[springs[order]]), colors=COLOURS(norm(errors[order])), lw=widths))
    for kind, chosen in _not_identified(identified).items():
        colour, dashes = LOOKS[kind]
        lines = list(nodes[springs[chosen]])
        axes.add_collection(LineCollection(lines, colors=colour, lw=2.6 * depth, linestyles=[dashes], zorder=4))
    axes.plot(*nodes.T, "o", color=style.INK, markersize=2.2, markeredgewidth=0, zorder=5)
    axes.set_aspect("equal")
    axes.set_axis_off()


def _draw_order(axes: Axes, identified: Identified, norm: LogNorm) -> None:
    """Sorted standard errors; the springs without one follow at the upper edge."""
    errors = np.sort(identified.standard_errors[np.isfinite(identified.standard_errors)])
    axes.scatter(np.arange(len(errors)), errors, c=COLOURS(norm(errors)), s=9, linewidths=0, zorder=3)
    begin = len(errors)
    for kind, chosen in _not_identified(identified).items():
        count = int(np.count_nonzero(chosen))
        ends, top = (begin - 0.5, begin + count - 0.5), axes.get_xaxis_transform()
        axes.plot(ends, (0.985, 0.985), color=LOOKS[kind][0], lw=3.0, transform=top, solid_capstyle="butt")
        begin += count
    axes.set_yscale("log")
    axes.set_ylim(norm.vmin / 1.3, norm.vmax * 1.6)  # type: ignore[operator]
    axes.set_xlabel("springs, best first")
    style.plain_ticks(axes.yaxis)


def _not_identified(identified: Identified) -> dict[str, Booleans]:
    """The springs without a standard error, by kind, where there are any."""
    infinite = ~np.isfinite(identified.standard_errors)
    kinds = {"unseen": infinite & ~identified.is_seen, "shared": infinite & identified.is_seen}
    return {kind: chosen for kind, chosen in kinds.items() if chosen.any()}


def _norm(errors: Floats) -> LogNorm:
    finite = errors[np.isfinite(errors) & (errors > 0)]
    low, high = (finite.min(), finite.max()) if len(finite) else (1.0, 10.0)
    return LogNorm(low, max(high, 1.05 * low))


def _limits(nodes: Floats) -> tuple[Floats, Floats]:
    margin = 0.03 * np.ptp(nodes, axis=0).max()
    return nodes.min(axis=0) - margin, nodes.max(axis=0) + margin


def _legend(identified: Identified) -> list[Line2D]:
    labels = {
        "unseen": "unseen: moves no node in any load case",
        "shared": "shared: other springs can make up for it",
    }
    return [
        Line2D([], [], color=LOOKS[kind][0], linestyle=LOOKS[kind][1], lw=2.2, label=f"{labels[kind]} ({count})")
        for kind, chosen in _not_identified(identified).items()
        if (count := np.count_nonzero(chosen))
    ]
