"""How a run came to its answer: the best value over the evaluations."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from springopt.report import style
from springopt.run import Improvement


def draw_convergence(axes: Axes, history: Sequence[Improvement], evaluations: int) -> None:
    """Best value on a log scale, from the first answer to the last evaluation; a value of zero ends at the bottom."""
    counts = np.array([improvement.evaluations for improvement in history])
    values = np.array([improvement.value for improvement in history])
    bottom = style.bottom(values)
    counts, values = np.append(counts, evaluations), np.append(values, values[-1])
    axes.step(counts, np.maximum(values, bottom), where="post", color=style.INK, linewidth=1.0)
    axes.set_yscale("log")
    axes.set_xlabel("evaluations")
    axes.set_ylabel("objective, best so far")
    axes.set_title("Convergence", loc="left", fontweight="bold")
    axes.annotate(
        f"{values[-1]:.4g}", (counts[-1], max(values[-1], bottom)), (-2, 4), textcoords="offset points", ha="right"
    )
