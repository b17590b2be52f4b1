"""What springs buy: the objective over the number of springs."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from springopt.front import Front
from springopt.report import style


def draw_front(axes: Axes, front: Front, spring_count: int) -> None:
    """The objective on a log scale; a value of zero lies at the bottom, and what is above the line was reached too."""
    values = np.maximum(front.values, style.bottom(front.values))
    axes.step(front.springs, values, where="post", color=style.REST, linewidth=1.0)
    axes.plot(front.springs, values, linestyle="none", marker="o", markersize=2.5, color=style.INK)
    axes.set_yscale("log")
    axes.xaxis.set_major_locator(MaxNLocator(integer=True, steps=[1, 2, 5, 10]))
    axes.set_xlabel(f"springs, of {spring_count}")
    axes.set_ylabel("objective")
    axes.set_title("Front", loc="left", fontweight="bold")
