"""One load case on paper: reference and model over each other and over the rest shape, with supports and forces."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection

from springopt.checks import Booleans, Floats
from springopt.lattice import SpringLattice
from springopt.load_case import LoadCase
from springopt.report import style
from springopt.report.body import project, visible


@dataclass(frozen=True, eq=False)
class Deformation:
    """One load case with the answers of reference and model, positions [length] of shape (n, d)."""

    case: LoadCase
    reference: Floats
    model: Floats
    caption: str


def deformations(
    cases: Sequence[LoadCase], reference: Floats, model: Floats, errors: Sequence[Mapping[str, Any]]
) -> list[Deformation]:
    """One for each load case, from positions (c, n, d), with the errors as captions; of a motion its last time."""
    reference, model = (positions if positions.ndim == 3 else positions[:, -1] for positions in (reference, model))
    captions = [f"error {error['relative_distance']:#.2g}, largest {error['max_distance']:#.2g}" for error in errors]
    return [Deformation(*parts) for parts in zip(cases, reference, model, captions, strict=True)]


def draw_deformation(axes: Axes, lattice: SpringLattice, present: Booleans, deformation: Deformation) -> None:
    """Fill the axes, which lose their frame; `present` says which springs the model has, shape (s,)."""
    rest, reference, model = (project(p) for p in (lattice.nodes, deformation.reference, deformation.model))
    body = visible(lattice)
    springs = lattice.springs[present & body.springs]
    joined = body.seen & np.isin(np.arange(lattice.node_count), lattice.springs[present])
    axes.add_collection(LineCollection(list(rest[body.lines]), colors=style.REST, linewidths=0.6, zorder=1))
    axes.add_collection(PolyCollection(list(reference[body.faces]), facecolor=style.REFERENCE, alpha=0.13, zorder=2))
    axes.add_collection(LineCollection(list(reference[body.lines]), colors=style.REFERENCE, **style.CASING, zorder=3))
    axes.add_collection(LineCollection(list(model[springs]), colors=style.MODEL, linewidths=0.6, zorder=4))
    axes.plot(*model[joined].T, "o", color=style.MODEL, markersize=1.8, markeredgewidth=0, zorder=5)
    for nodes, alpha in ((body.seen, 1.0), (~body.seen, 0.2)):
        draw_supports(axes, rest, deformation.case, nodes, alpha)
        draw_forces(axes, reference, deformation.case, lattice, nodes, alpha)
    axes.set_title(f"{deformation.case.name}\n{deformation.caption}", linespacing=1.3, pad=3)
    axes.set_aspect("equal")
    axes.set_axis_off()


def limits(lattice: SpringLattice, deformations: list[Deformation]) -> tuple[Floats, Floats]:
    """Lower left and upper right corner on paper that hold every load case, its forces too, shape (2,) each."""
    points = [project(lattice.nodes)]
    for deformation in deformations:
        reference = project(deformation.reference)
        points += [reference, project(deformation.model), reference + _arrows(deformation.case, lattice)]
    everything = np.concatenate(points)
    margin = 0.03 * np.ptp(everything, axis=0).max()
    return everything.min(axis=0) - margin, everything.max(axis=0) + margin


def draw_supports(axes: Axes, rest: Floats, case: LoadCase, nodes: Booleans, alpha: float) -> None:
    """Squares where these nodes are held, and open ones where they are moved to."""
    held = nodes & case.supports.any(axis=1)
    moved = held & (case.prescribed != 0).any(axis=1)
    look: dict[str, Any] = {"color": style.INK, "markersize": 3.0, "alpha": alpha, "zorder": 6}
    axes.plot(*rest[held & ~moved].T, "s", markeredgewidth=0, **look)
    axes.plot(*(rest + project(case.prescribed))[moved].T, "s", markerfacecolor="white", markeredgewidth=0.6, **look)


def draw_forces(
    axes: Axes, reference: Floats, case: LoadCase, lattice: SpringLattice, nodes: Booleans, alpha: float
) -> None:
    """Arrows at these nodes, whose positions on paper are given, shape (n, 2)."""
    loaded = nodes & case.forces.any(axis=1)
    if loaded.any():
        tails, arrows = reference[loaded], _arrows(case, lattice)[loaded]
        axes.quiver(*tails.T, *arrows.T, color=style.INK, alpha=alpha, zorder=7, **style.ARROW)


def _arrows(case: LoadCase, lattice: SpringLattice) -> Floats:
    """The forces as spans on paper, shape (n, 2); the largest one of the case is an eighth of the body long."""
    largest = np.linalg.norm(case.forces, axis=1).max()
    length = np.ptp(lattice.nodes, axis=0).max() / 8
    return project(case.forces * (length / largest if largest else 0.0))
