"""Lines of many methods in one drawing, told apart by colour-blind readers, each with its name at its end."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from springopt.checks import Floats

#: Okabe and Ito's colours without the yellow, which is too pale for a line.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#222222")
DASHES = ("-", (0, (4, 1.2)), (0, (1.2, 1.0)), (0, (5, 1.2, 1.2, 1.2)))

LINE_HEIGHT = 8.5  # points


def looks(methods: Sequence[str]) -> dict[str, dict[str, Any]]:
    """Colour and dashes of each method's line; the first seven differ in colour, the next ones in dashes as well."""
    return {
        method: {"color": COLOURS[i % len(COLOURS)], "linestyle": DASHES[i // len(COLOURS) % len(DASHES)]}
        for i, method in enumerate(methods)
    }


def name_ends(axes: Axes, heights: Mapping[str, float], looks: Mapping[str, Mapping[str, Any]]) -> None:
    """Writes each line's name to the right of the drawing, level with its end or as near as the names let it.

    Args:
        axes: with its limits set, and size.
        heights: name -> where its line ends, in the axes' data.
    """
    points = axes.bbox.height * 72 / axes.figure.dpi
    names = sorted(heights, key=lambda name: heights[name])
    ends = axes.transAxes.inverted().transform(axes.transData.transform([(1.0, heights[name]) for name in names]))[:, 1]
    place: dict[str, Any] = {"transform": axes.transAxes, "clip_on": False}
    for name, end, level in zip(names, ends, _apart(ends, LINE_HEIGHT / points), strict=True):
        axes.plot([1.0, 1.04], [end, level], color=looks[name]["color"], linewidth=0.4, **place)
        axes.plot([1.04, 1.085], [level, level], linewidth=1.1, **looks[name], **place)
        axes.text(1.095, level, name, va="center", fontsize=6.8, color=looks[name]["color"], **place)


def _apart(levels: Floats, distance: float) -> Floats:
    """Rising levels moved as little as it takes, in the sum of squares, until neighbours are this far apart.

    By pooling neighbours that would overlap (isotonic regression of the levels less their share of the distance); none
    of them below zero.
    """
    shifts = distance * np.arange(len(levels))
    groups: list[list[float]] = []
    for level in levels - shifts:
        groups.append([level])
        while len(groups) > 1 and np.mean(groups[-2]) >= np.mean(groups[-1]):
            last = groups.pop()
            groups[-1] += last
    pooled = np.concatenate([np.full(len(group), np.mean(group)) for group in groups])
    return np.maximum(pooled, 0.0) + shifts
