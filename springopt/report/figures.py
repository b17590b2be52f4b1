"""A whole run on one page: every load case, training and test, then convergence, the front and stiffness."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from math import ceil
from pathlib import Path
from textwrap import fill
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
from springopt.report.motion import draw_course, draw_distances
from springopt.report.stiffness import draw_stiffness
from springopt.run import Improvement

PANEL_WIDTH = 1.65  # inches
MOTION_WIDTH, COURSE_HEIGHT = 2.3, 1.15
MOST_COLUMNS, MOST_MOTIONS = 6, 4
TITLE_DENSITY = 12  # characters an inch
WIDE = 1.3  # the panel of stiffness with its long legend, beside the others of the summary
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

    @property
    def is_motion(self) -> bool:
        return self.deformations[0].case.times is not None


def draw(learned: Learned) -> Figure:
    """Rows of training load cases, rows of test ones, then convergence, front and the histogram of stiffness.

    Of a motion each load case is drawn at its last time, earlier ones pale, and below it one node over time.
    """
    strips = [(label, of_role) for role, label in ROLES.items() if (of_role := _of_role(learned, role))]
    panel_width = MOTION_WIDTH if learned.is_motion else PANEL_WIDTH
    most = MOST_MOTIONS if learned.is_motion else MOST_COLUMNS
    columns = max(5 if learned.front else 3, *(_columns(len(of_role), most) for _, of_role in strips))
    low, high = limits(learned.lattice, learned.deformations)
    width, height = high - low
    parts = [panel_width * min(height / width, 1.6) + 0.35] + [COURSE_HEIGHT] * learned.is_motion
    heights = [sum(parts) * ceil(len(of_role) / columns) for _, of_role in strips] + [2.3]
    with rc_context(style.SETTINGS):
        figure = Figure(figsize=(panel_width * columns + 0.3, sum(heights) + 0.6), layout="constrained")
        title = fill(learned.title, int(TITLE_DENSITY * figure.get_figwidth()))
        figure.suptitle(title, fontsize=9.5, fontweight="bold")
        *frames, below = figure.subfigures(len(heights), 1, squeeze=False, height_ratios=heights)[:, 0]
        for frame, (label, of_role) in zip(frames, strips, strict=True):
            frame.supylabel(label, fontsize=9, fontweight="bold")
            for (axes, *below_it), deformation in _panels(frame, columns, of_role, parts):
                draw_deformation(axes, learned.lattice, learned.stiffness > 0, deformation)
                axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
                for course in below_it:
                    draw_course(course, learned.lattice, deformation)
        _draw_summary(below, learned)
        marks = _legend(learned.is_motion)
        figure.legend(handles=marks, loc="outside lower center", ncols=7, title=CAPTION, **style.LEGEND)
    return figure


def save(figure: Figure, path: Path) -> None:
    """Write the figure in the format of the path's ending."""
    with rc_context(style.SETTINGS):
        figure.savefig(path, dpi=200)


def _draw_summary(frame: SubFigure, learned: Learned) -> None:
    """Convergence, front and distance over time, where there are such, and the stiffness."""
    count = 1 + bool(learned.history) + bool(learned.front) + learned.is_motion
    *left, right = frame.subplots(1, count, squeeze=False, width_ratios=[*[1.0] * (count - 1), WIDE])[0]
    if learned.history:
        draw_convergence(left.pop(0), learned.history, learned.evaluations)
    if learned.front:
        draw_front(left.pop(0), learned.front, learned.lattice.spring_count)
    if learned.is_motion:
        draw_distances(left.pop(0), learned.deformations)
    draw_stiffness(right, learned.stiffness, _classes(learned.lattice))


def _of_role(learned: Learned, role: str) -> list[Deformation]:
    return [deformation for deformation in learned.deformations if deformation.case.role == role]


def _columns(count: int, most: int) -> int:
    """As many as fill the fewest rows evenly."""
    return ceil(count / ceil(count / most))


def _panels(
    frame: SubFigure, columns: int, of_role: list[Deformation], heights: list[float]
) -> Iterator[tuple[list[Axes], Deformation]]:
    """Axes of these heights above each other for each deformation, in rows; those left over in the last are blank."""
    rows, parts = ceil(len(of_role) / columns), len(heights)
    grid = frame.subplots(rows * parts, columns, squeeze=False, height_ratios=heights * rows)
    panels = grid.reshape(rows, parts, columns).swapaxes(1, 2).reshape(-1, parts).tolist()
    for blank in panels[len(of_role) :]:
        for axes in blank:
            axes.set_axis_off()
    return zip(panels, of_role, strict=False)


def _classes(lattice: SpringLattice) -> SpringClasses:
    """The finest classes; all springs only where there is no other."""
    known = known_classes(lattice)
    return {name: mask for name, mask in known.items() if name != "all springs"} or known


def _legend(is_motion: bool) -> list[Line2D]:
    def dots(label: str, marker: str, **look: Any) -> Line2D:
        return Line2D([], [], color=style.INK, linestyle="none", marker=marker, label=label, **look)

    ghosts = [Line2D([], [], color=style.MODEL, linewidth=0.5, alpha=0.5, label="earlier")] if is_motion else []
    return [
        Line2D([], [], color=style.REFERENCE, linewidth=2.6, alpha=0.45, label="reference"),
        Line2D([], [], color=style.MODEL, linewidth=0.7, marker="o", markersize=2, label="mass-spring model"),
        *ghosts,
        Line2D([], [], color=style.REST, linewidth=0.8, label="rest shape"),
        dots("held", "s", markersize=3),
        dots("moved", "s", markersize=3, markerfacecolor="white", markeredgewidth=0.6),
        dots("force", r"$\rightarrow$", markersize=9),
    ]
