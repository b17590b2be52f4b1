"""Which stiffness the springs got, class by class, as in Figure 4 of Bianchi et al. (2004)."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from springopt.checks import Floats
from springopt.encoding.spring_classes import SpringClasses, summarize
from springopt.report import style


def draw_stiffness(axes: Axes, stiffness: Floats, classes: SpringClasses) -> None:
    """A histogram of the present springs, the classes stacked; the legend counts and averages them."""
    present = {name: stiffness[mask & (stiffness > 0)] for name, mask in classes.items()}
    rows = summarize(stiffness, classes)
    labels = [
        f"{name}: {row['present']:g} of {row['springs']:g}, {row['mean']:.2f} ± {row['spread']:.2f}"
        for name, row in rows.items()
    ]
    axes.hist(
        list(present.values()),
        bins=_bins(stiffness).tolist(),
        stacked=True,
        color=[style.CLASS_COLOURS.get(name, style.REST) for name in classes],
        edgecolor="white",
        linewidth=0.4,
        label=labels,
    )
    axes.set_xlabel("stiffness")
    axes.set_ylabel("springs")
    axes.set_title("Stiffness", loc="left", fontweight="bold")
    axes.margins(y=0.12 + 0.14 * len(classes))  # room for the legend over the bars
    axes.legend(loc="upper left", handlelength=1.0, handleheight=0.8)


def _bins(stiffness: Floats) -> Floats:
    """From zero in about 30 round steps."""
    top = float(stiffness.max(initial=0.0)) or 1.0
    step = 10 ** np.floor(np.log10(top / 20))
    step *= next(factor for factor in (1, 2, 2.5, 5, 10) if top / (factor * step) <= 40)
    return np.arange(0.0, top + 1.01 * step, step)
