"""Load cases in motion on paper, over time: the node that moves furthest, and the distance from the reference."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from springopt.checks import Floats
from springopt.lattice import SpringLattice
from springopt.load_case import LoadCase
from springopt.report import style
from springopt.report.deformation import Deformation

AXES = "xyz"


def draw_course(axes: Axes, lattice: SpringLattice, deformation: Deformation) -> None:
    """The displacement over time of the node that moves furthest, along the axis where it does, from rest on."""
    case, reference, model = deformation.case, *(deformation.motion(name) for name in ("reference", "model"))
    node, axis = _furthest(case, reference - lattice.nodes)
    times, rest = _times(case), lattice.nodes[node, axis]
    courses = [np.concatenate([[0.0], motion[:, node, axis] - rest]) for motion in (reference, model)]
    axes.axhline(0.0, color=style.REST, linewidth=0.6, zorder=1)
    look: dict[str, Any] = {"solid_capstyle": "round", "linewidth": style.CASING["linewidths"]}
    axes.plot(times, courses[0], color=style.REFERENCE, alpha=style.CASING["alpha"], zorder=2, **look)
    axes.plot(times, courses[1], "o-", color=style.MODEL, linewidth=0.8, markersize=2.0, markeredgewidth=0, zorder=3)
    axes.set_xlim(0.0, times[-1])
    axes.set_title(f"{AXES[axis]} displacement, node {node} [length]", pad=3)
    axes.set_xlabel("time", labelpad=1)
    axes.locator_params(axis="y", nbins=4)
    axes.locator_params(axis="x", nbins=5)


def draw_distances(axes: Axes, deformations: Sequence[Deformation]) -> None:
    """The mean distance of the nodes over time, a line a load case."""
    looks: dict[str, dict[str, Any]] = {
        "train": {"color": style.MODEL},
        "test": {"color": style.INK, "linestyle": (0, (3, 1.5))},
    }
    names = {"train": "training", "test": "test"}
    for deformation in deformations:
        reference, model = deformation.motion("reference"), deformation.motion("model")
        distances = np.linalg.norm(model - reference, axis=-1).mean(axis=-1)
        label = names.pop(deformation.case.role, None)
        times, look = _times(deformation.case), looks[deformation.case.role]
        axes.plot(times, np.concatenate([[0.0], distances]), linewidth=0.9, label=label, **look)
    axes.set_xlim(0.0, _times(deformations[0].case)[-1])
    axes.set_ylim(0.0, 1.25 * axes.dataLim.y1 or 1.0)  # room for the legend over the lines
    axes.set_xlabel("time")
    axes.set_ylabel("mean distance [length]")
    axes.set_title("Distance over time", loc="left", fontweight="bold")
    axes.legend(loc="upper left", ncols=2, handlelength=1.6)


def _furthest(case: LoadCase, displacements: Floats) -> tuple[int, int]:
    """The free degree of freedom (node, axis) that moves furthest in (t, n, d); of a held body any."""
    reach = np.abs(displacements).max(axis=0)
    free = np.where(case.free, reach, -1.0) if case.free.any() else reach
    node, axis = np.unravel_index(int(free.argmax()), free.shape)
    return int(node), int(axis)


def _times(case: LoadCase) -> Floats:
    """From the rest at time 0 on, shape (1 + t,)."""
    assert case.times is not None, "or nothing would be drawn over time"
    return np.concatenate([[0.0], case.times])
