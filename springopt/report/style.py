"""The look of every figure: colours that colour-blind readers tell apart, and small print."""

from __future__ import annotations

from typing import Any

from matplotlib.axis import Axis
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

from springopt.checks import Floats

REFERENCE = "#0072B2"
MODEL = "#D55E00"
REST = "#C8C8C8"
INK = "#222222"
CLASS_COLOURS = {
    "all springs": "#7F7F7F",
    "straight": "#56B4E9",
    "inner straight": "#56B4E9",
    "boundary straight": "#E69F00",
    "diagonal": "#009E73",
}
#: Lines of one drawing, in this order (Okabe and Ito's colours).
SERIES = ("#D55E00", "#E69F00", "#56B4E9", "#222222", "#009E73", "#CC79A7", "#0072B2")

#: The reference's lines, wide and pale enough to see the model's on top.
CASING: dict[str, Any] = {"linewidths": 2.6, "alpha": 0.45, "capstyle": "round"}
#: Arrows in the units of the drawing.
ARROW: dict[str, Any] = {
    "angles": "xy",
    "scale_units": "xy",
    "scale": 1.0,
    "width": 0.011,
    "headwidth": 3.6,
    "headlength": 3.6,
    "headaxislength": 3.4,
}
#: Narrow enough for all marks in one row of the smallest page.
LEGEND: dict[str, Any] = {"handlelength": 1.6, "handletextpad": 0.5, "columnspacing": 1.0}

SETTINGS: Any = {
    "font.size": 8,
    "axes.titlesize": 8,
    "axes.labelsize": 8,
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": INK,
    "text.color": INK,
    "axes.labelcolor": INK,
    "legend.fontsize": 7.5,
    "legend.frameon": False,
    "xtick.labelsize": 7.5,
    "ytick.labelsize": 7.5,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "pdf.fonttype": 42,
}


def bottom(values: Floats) -> float:
    """Where a log scale shows zero: a decade below the least positive value."""
    positive = values[values > 0]
    return float(positive.min()) / 10 if positive.size else 1e-16


def plain_ticks(axis: Axis) -> None:
    """On a log scale 0.1, 0.2, 0.5, 1 and so on, and not powers of ten alone."""
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_major_formatter(FuncFormatter(lambda number, _: f"{number:g}"))
    axis.set_minor_locator(NullLocator())
