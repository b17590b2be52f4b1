"""Stiffness on meshes of several sizes: its distribution, what it is made of, and what the boundary does to it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from springopt.checks import Floats
from springopt.encoding.spring_classes import SpringClasses, inner_boundary_diagonal
from springopt.lattice import SpringLattice
from springopt.report import style

EDGES = np.arange(0.0, 10.25, 0.25)
SHADES = (style.INK, style.CLASS_COLOURS["boundary straight"])


@dataclass(frozen=True, eq=False)
class Mesh:
    """A free fit on one mesh."""

    title: str
    lattice: SpringLattice
    stiffness: Floats  #: shape (s,)


def draw_meshes(meshes: Sequence[Mesh], shares: Mapping[str, Sequence[float]], parts: Sequence[str]) -> Figure:
    """A histogram and the stiffness by depth for each mesh; then the parts of the variance at every size.

    Args:
        meshes: the free fits.
        shares: for each size the parts of its variance, which sum up to 1.
        parts: what they are called.
    """
    with rc_context(style.SETTINGS):
        figure = Figure(figsize=(1.8 * len(meshes) + 2.4, 4.0), layout="constrained")
        grid = figure.subplots(2, len(meshes) + 1, width_ratios=[1.0] * len(meshes) + [1.15])
        for column, mesh in zip(grid.T, meshes, strict=False):
            classes = inner_boundary_diagonal(mesh.lattice)
            _draw_histogram(column[0], mesh, classes)
            _draw_depths(column[1], mesh, classes)
        grid[0, 0].set_ylabel("share of the springs")
        grid[1, 0].set_ylabel("stiffness")
        _draw_shares(grid[1, -1], shares, parts)
        _draw_legends(grid)
    return figure


def _draw_histogram(axes: Axes, mesh: Mesh, classes: SpringClasses) -> None:
    count = len(mesh.stiffness)
    axes.hist(
        [mesh.stiffness[mask] for mask in classes.values()],
        bins=EDGES.tolist(),
        weights=[np.full(np.count_nonzero(mask), 1 / count) for mask in classes.values()],
        stacked=True,
        color=[style.CLASS_COLOURS[name] for name in classes],
        label=list(classes),
    )
    axes.set(title=mesh.title, xlabel="stiffness", xlim=(0, 10))


def _draw_depths(axes: Axes, mesh: Mesh, classes: SpringClasses) -> None:
    """The mean of each class at each distance from the boundary, and how far the springs there spread."""
    depth = depths(mesh.lattice)
    for name, mask in classes.items():
        steps = np.unique(depth[mask])
        rings = [mesh.stiffness[mask & (depth == step)] for step in steps]
        means, spreads = (np.array([measure(ring) for ring in rings]) for measure in (np.mean, np.std))
        axes.errorbar(steps, means, spreads, color=style.CLASS_COLOURS[name], marker="o", markersize=3, linewidth=1)
    axes.set(xlabel="distance from the boundary", ylim=(0, 10))


def depths(lattice: SpringLattice) -> Floats:
    """How far the middle of each spring is from the nearest side of the bounding box [length], shape (s,)."""
    middles = lattice.nodes[lattice.springs].mean(axis=1)
    low, high = lattice.nodes.min(axis=0), lattice.nodes.max(axis=0)
    return np.round(np.minimum(middles - low, high - middles).min(axis=1), 9)


def _draw_shares(axes: Axes, shares: Mapping[str, Sequence[float]], parts: Sequence[str]) -> None:
    below = np.zeros(len(shares))
    for part, of_part, shade in zip(parts, np.array(list(shares.values())).T, SHADES, strict=False):
        axes.bar(range(len(shares)), of_part, bottom=below, color=shade, label=part, width=0.7)
        below += of_part
    axes.set_xticks(range(len(shares)), list(shares))
    axes.set(xlabel="nodes along a side", ylabel="share of the variance", ylim=(0, 1))


def _draw_legends(grid: Any) -> None:
    """Both where no histogram is, over the shares."""
    place = grid[0, -1]
    place.set_axis_off()
    springs = place.legend(*grid[0, 0].get_legend_handles_labels(), loc="upper center", title="springs")
    place.add_artist(springs)
    place.legend(*grid[1, -1].get_legend_handles_labels(), loc="lower center", title="variance of three classes")
