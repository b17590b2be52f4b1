"""Load cases in the rows of Figures 2 and 3 of Bianchi et al. (2004): loads, the reference, the model."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure

from springopt.checks import Booleans, Floats
from springopt.lattice import SpringLattice
from springopt.report import style
from springopt.report.body import project, visible
from springopt.report.deformation import Deformation, draw_forces, draw_supports, limits
from springopt.store import RunFile

PANEL, WIDTH = 1.75, 8.8  # inches: of a panel, and of the figure at most
ROWS = ("loads", "reference", "model")


def draw_rows(file: RunFile, names: Sequence[str], captions: Sequence[str] = ()) -> Figure:
    """A column for each load case of these names, with a caption below; springs that are missing are dashed."""
    numbers = [next(i for i, case in enumerate(file.cases) if case.name == name) for name in names]
    chosen = [Deformation(file.cases[i], file.reference_positions[i], file.positions[i], "") for i in numbers]
    low, high = limits(file.lattice, chosen)
    width, height = high - low
    with rc_context(style.SETTINGS):
        panel = min(PANEL, WIDTH / len(names))
        size = (panel * len(names) + 0.4, 3 * panel * min(height / width, 1.3) + 0.7)
        figure = Figure(figsize=size, layout="constrained")
        panels = figure.subplots(len(ROWS), len(names), squeeze=False)
        for column, shown in zip(panels.T, chosen, strict=True):
            _draw_column(column, file.lattice, file.run.stiffness > 0, shown)
        for axes, label in zip(panels[:, 0], ROWS, strict=True):
            axes.set_ylabel(label, fontsize=9, fontweight="bold")
        for axes, caption in zip(panels[-1], captions, strict=False):
            axes.set_xlabel(caption)
        for axes in panels.flat:
            axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal", xticks=[], yticks=[])
            axes.spines[:].set_visible(False)
    return figure


def _draw_column(column: Sequence[Axes], lattice: SpringLattice, present: Booleans, shown: Deformation) -> None:
    rest, everything = project(lattice.nodes), np.ones(lattice.spring_count, dtype=bool)
    loads, reference, model = column
    loads.set_title(shown.case.name)
    _draw_body(loads, lattice, lattice.nodes, everything, style.INK)
    seen = visible(lattice).seen
    draw_supports(loads, rest, shown.case, seen, 1.0)
    draw_forces(loads, rest, shown.case, lattice, seen, 1.0)
    _draw_body(reference, lattice, shown.reference, everything, style.REFERENCE)
    _draw_body(model, lattice, shown.model, present, style.MODEL)


def _draw_body(axes: Axes, lattice: SpringLattice, positions: Floats, present: Booleans, colour: str) -> None:
    body, paper = visible(lattice), project(positions)
    axes.add_collection(PolyCollection(list(paper[body.faces]), facecolor=colour, alpha=0.13))
    drawn = lattice.springs[present & body.springs]
    axes.add_collection(LineCollection(list(paper[drawn]), colors=colour, linewidths=0.7))
    absent = lattice.springs[~present]
    axes.add_collection(LineCollection(list(paper[absent]), colors=style.INK, linewidths=1.4, linestyles="dashed"))
