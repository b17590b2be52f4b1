"""One load case in motion on paper: where the body was earlier, and the node that moves furthest, over time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection

from springopt.checks import Floats
from springopt.lattice import SpringLattice
from springopt.load_case import LoadCase
from springopt.report import style
from springopt.report.body import Body, project

if TYPE_CHECKING:
    from springopt.report.deformation import Deformation

GHOSTS = 2  # earlier times that are drawn beside the last one
AXES = "xyz"
_EARLIER = {
    "reference": {"colors": style.REFERENCE, "linewidths": 1.6, "alpha": 0.2, "capstyle": "round", "zorder": 1.5},
    "model": {"colors": style.MODEL, "linewidths": 0.5, "alpha": 0.5, "zorder": 1.7},
}


def earlier(motion: Floats) -> Floats:
    """Positions (t, n, d) at a few evenly spread times before the last one."""
    count = len(motion)
    chosen = np.unique(np.linspace(0, count, GHOSTS + 2).astype(int)[1:-1] - 1)
    return motion[chosen[(chosen >= 0) & (chosen < count - 1)]]


def draw_ghosts(axes: Axes, body: Body, deformation: Deformation) -> None:
    """The lines of reference and model at earlier times, pale."""
    for name, look in _EARLIER.items():
        for positions in earlier(deformation.motion(name)):
            axes.add_collection(LineCollection(list(project(positions)[body.lines]), **look))


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
    looks = {"train": {"color": style.MODEL}, "test": {"color": style.INK, "linestyle": (0, (3, 1.5))}}
    names = {"train": "training", "test": "test"}
    for deformation in deformations:
        reference, model = deformation.motion("reference"), deformation.motion("model")
        distances = np.linalg.norm(model - reference, axis=-1).mean(axis=-1)
        label = names.pop(deformation.case.role, None)
        look: dict[str, Any] = looks[deformation.case.role]
        times = _times(deformation.case)
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
