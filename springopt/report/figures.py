"""A whole run on one page: every load case, training and test, then convergence, the front and stiffness."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from math import ceil
from pathlib import Path
from typing import Any

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure
from matplotlib.lines import Line2D

from springopt.checks import Floats
from springopt.encoding.spring_classes import SpringClasses, known_classes
from springopt.front import Front
from springopt.lattice import SpringLattice
from springopt.report import style
from springopt.report.convergence import draw_convergence
from springopt.report.deformation import Deformation, draw_deformation, limits
from springopt.report.front import draw_front
from springopt.report.stiffness import draw_stiffness
from springopt.run import Improvement

PANEL_WIDTH = 1.65  # inches
MOST_COLUMNS = 6
CAPTION = "error: mean distance of the nodes over the smallest rest length; largest: distance of any node"
ROLES = {"train": "Training", "test": "Test"}


@dataclass(frozen=True, eq=False)
class Learned:
    """What a figure shows of a run."""

    title: str
    lattice: SpringLattice
    stiffness: Floats  #: shape (s,)
    deformations: list[Deformation]
    history: Sequence[Improvement] = ()  #: empty where nothing was learned
    evaluations: int = 0
    front: Front = field(default_factory=Front)


def draw(learned: Learned) -> Figure:
    """Rows of training load cases, rows of test ones, then convergence, front and the histogram of stiffness."""
    strips = [(label, of_role) for role, label in ROLES.items() if (of_role := _of_role(learned, role))]
    columns = max(5 if learned.front else 3, *(_columns(len(of_role)) for _, of_role in strips))
    low, high = limits(learned.lattice, learned.deformations)
    width, height = high - low
    panel_height = PANEL_WIDTH * min(height / width, 1.6) + 0.35
    heights = [panel_height * ceil(len(of_role) / columns) for _, of_role in strips] + [2.3]
    with rc_context(style.SETTINGS):
        figure = Figure(figsize=(PANEL_WIDTH * columns + 0.3, sum(heights) + 0.6), layout="constrained")
        figure.suptitle(learned.title, fontsize=9.5, fontweight="bold")
        *frames, below = figure.subfigures(len(heights), 1, squeeze=False, height_ratios=heights)[:, 0]
        for frame, (label, of_role) in zip(frames, strips, strict=True):
            frame.supylabel(label, fontsize=9, fontweight="bold")
            for axes, deformation in _panels(frame, columns, of_role):
                draw_deformation(axes, learned.lattice, learned.stiffness > 0, deformation)
                axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
        _draw_summary(below, learned)
        figure.legend(handles=_legend(), loc="outside lower center", ncols=6, title=CAPTION, **style.LEGEND)
    return figure


def save(figure: Figure, path: Path) -> None:
    """Write the figure in the format of the path's ending."""
    with rc_context(style.SETTINGS):
        figure.savefig(path, dpi=200)


def _draw_summary(frame: SubFigure, learned: Learned) -> None:
    """Convergence and front, where there are such, and the stiffness."""
    *left, right = frame.subplots(1, 1 + bool(learned.history) + bool(learned.front), squeeze=False)[0]
    if learned.history:
        draw_convergence(left.pop(0), learned.history, learned.evaluations)
    if learned.front:
        draw_front(left.pop(0), learned.front, learned.lattice.spring_count)
    draw_stiffness(right, learned.stiffness, _classes(learned.lattice))


def _of_role(learned: Learned, role: str) -> list[Deformation]:
    return [deformation for deformation in learned.deformations if deformation.case.role == role]


def _columns(count: int) -> int:
    """As many as fill the fewest rows evenly."""
    return ceil(count / ceil(count / MOST_COLUMNS))


def _panels(frame: SubFigure, columns: int, of_role: list[Deformation]) -> Iterator[tuple[Axes, Deformation]]:
    """Axes in rows for the deformations; those left over in the last row are blank."""
    grid = frame.subplots(ceil(len(of_role) / columns), columns, squeeze=False).ravel()
    for blank in grid[len(of_role) :]:
        blank.set_axis_off()
    return zip(grid, of_role, strict=False)


def _classes(lattice: SpringLattice) -> SpringClasses:
    """The finest classes; all springs only where there is no other."""
    known = known_classes(lattice)
    return {name: mask for name, mask in known.items() if name != "all springs"} or known


def _legend() -> list[Line2D]:
    def dots(label: str, marker: str, **look: Any) -> Line2D:
        return Line2D([], [], color=style.INK, linestyle="none", marker=marker, label=label, **look)

    return [
        Line2D([], [], color=style.REFERENCE, linewidth=2.6, alpha=0.45, label="reference"),
        Line2D([], [], color=style.MODEL, linewidth=0.7, marker="o", markersize=2, label="mass-spring model"),
        Line2D([], [], color=style.REST, linewidth=0.8, label="rest shape"),
        dots("held", "s", markersize=3),
        dots("moved", "s", markersize=3, markerfacecolor="white", markeredgewidth=0.6),
        dots("force", r"$\rightarrow$", markersize=9),
    ]
