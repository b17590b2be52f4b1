"""Variations of a scene in how many cells its grid has, all judged by one finite element mesh that is finer than any.

The loads. A model is loaded as the scene states it: the total on a side is spread evenly over its nodes, few or many.
On the fine mesh the same total is a uniform traction, by the consistent nodal forces of first-order elements: so that
the reference is the body's, and what an even spread over few nodes is off by is the model's error. A force at a node
that is named stays a point force on all of them; the finer a mesh, the further that node gives way, without a limit, so
that errors of such load cases hold for this mesh alone. The reference is without the noise of the scene's.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np

from springopt.checks import Floats
from springopt.errors import UserError
from springopt.lattice import SpringLattice, side
from springopt.load_case import LoadCase
from springopt.scene import Scene, Setup
from springopt.scene.build import build_model
from springopt.scene.lattice_tables import GridTable
from springopt.scene.reference_tables import FemTable
from springopt.tradeoff.axes.model.resampling import Transfer, parts, resampled, why_fixed
from springopt.tradeoff.axes.model.variation import CLASSES, FREE, Variation, Variations, made_ready, with_encoding

FACTORS = {Fraction(1, 2): "half", Fraction(1): "the same", Fraction(2): "double", Fraction(4): "four times"}
FINER = 2  # the cells of the reference along an axis, over those of the finest lattice
#: Unknowns of a reference that is found in seconds: of a linear law in 2D and 3D, at large strain, and in motion.
LARGEST_FLAT, LARGEST_SOLID, LARGEST_STRAIN, LARGEST_MOTION = 40_000, 8_000, 3_000, 1_000


def resolutions(setup: Setup) -> Variations:
    """Half, the same, double and four times as many cells, with the finest classes of springs and with free ones."""
    scene = setup.scene
    why = "its reference is no finite element mesh" if not isinstance(scene.reference, FemTable) else why_fixed(scene)
    if why is not None:
        return Variations(notes=(f"There is no series resolution for this scene, because {why}.",))
    assert isinstance(scene.lattice, GridTable)
    base = np.array(scene.lattice.grid) - 1
    counts = {factor: base * factor.numerator // factor.denominator for factor in FACTORS}
    whole = [f for f, cells in counts.items() if (cells >= 1).all() and (base * f.numerator % f.denominator == 0).all()]
    chosen = [factor for factor in whole if _unknowns(FINER * counts[factor]) <= _largest(scene)]
    if Fraction(1) not in chosen:
        return Variations(notes=("There is no series resolution: a reference of twice the cells would be too large.",))
    fine = FINER * counts[max(chosen)]
    try:
        positions = fine_positions(scene, tuple(fine))
    except UserError as error:
        return Variations(notes=(f"There is no series resolution, as its fine reference can't be had: {error}",))
    shape = " x ".join(str(count + 1) for count in fine)
    notes = [
        f"Errors of the series resolution are against a finer mesh, of {shape} nodes; those of the others against the "
        "scene's own reference, so that they do not compare."
    ]
    notes += [f"The series resolution has no {FACTORS[f]}: {_absent(f, whole)}." for f in FACTORS if f not in chosen]
    found: list[Variation] = []
    for factor in chosen:
        try:
            found += _at(scene, factor, counts[factor], fine, positions)
        except UserError as error:
            notes.append(f"The series resolution has no {FACTORS[factor]}: {error}")
    return Variations(tuple(found), tuple(notes))


def fine_positions(scene: Scene, cells: tuple[int, ...]) -> Floats:
    """The reference of a scene on a mesh of so many cells [length], shape (c, n, d), or (c, t, n, d) with times."""
    # Springs decide nothing here; those along the axes are the fewest.
    table = scene.lattice.model_copy(update={"neighbourhood": "von-neumann", "radius": 1})
    fine = resampled(with_encoding(scene, "homogeneous").model_copy(update={"lattice": table}), cells)
    lattice = fine.lattice.build()
    reference = fine.reference.build(build_model(fine, lattice))
    cases = fine.load_cases.build(lattice)
    return np.stack([reference.deform(case) for case in _consistent(scene, cells, lattice, cases)])


def _consistent(
    scene: Scene, cells: tuple[int, ...], lattice: SpringLattice, cases: list[LoadCase]
) -> Iterator[LoadCase]:
    """The load cases of a fine lattice, each total on sides a uniform traction."""
    assert isinstance(scene.lattice, GridTable)
    transfer = Transfer(scene.lattice, cells)
    for table, case in zip([*scene.load_cases.train, *scene.load_cases.test], cases, strict=True):
        forces = np.zeros_like(case.forces)
        for push in table.push:
            sides, total, nodes, force = parts(push.model_dump(), transfer.lattice)
            if sides:
                forces += np.outer(traction_shares(lattice, sides), total)
            for node in nodes:
                for corner, share in transfer.around(node):
                    forces[corner] += share * force
        yield replace(case, forces=scene.load_cases.scale * forces)


def traction_shares(lattice: SpringLattice, sides: list[str]) -> Floats:
    """What each node of a grid bears of a uniform traction on these sides, shape (n,), one in all."""
    shares = np.zeros(lattice.node_count)
    for name in sides:
        on_side = side(lattice, name)
        nodes = lattice.nodes[on_side]
        low, high = nodes.min(axis=0), nodes.max(axis=0)
        # Half of a cell's face at an edge of the side, a quarter at its corner; nothing halves across the side.
        at_ends = (np.isclose(nodes, low) | np.isclose(nodes, high)) & (high > low)
        weights = 0.5 ** at_ends.sum(axis=1)
        shares[on_side] += weights / weights.sum() * np.prod(np.where(high > low, high - low, 1.0))
    return shares / shares.sum()


def _at(scene: Scene, factor: Fraction, cells: Any, fine: Any, positions: Floats) -> Iterator[Variation]:
    """With the finest classes that this lattice has, then with each spring on its own."""
    sampled = positions[..., _coinciding(cells, fine), :]
    nodes = " x ".join(str(count + 1) for count in cells)
    for kind in (_finest_classes(scene, cells), FREE):
        varied = resampled(with_encoding(scene, kind), tuple(cells))
        setup = made_ready(varied, varied.lattice.build(), sampled)
        assert isinstance(varied.lattice, GridTable)
        states = {"lattice.grid": varied.lattice.grid, "lattice.spacing": varied.lattice.spacing, "encoding.kind": kind}
        stated = factor == 1 and kind == scene.encoding.kind
        series = f"resolution, {'free' if kind == FREE else 'classes'}"
        yield Variation(series, f"{nodes} nodes", setup, states, stated, is_apart=True)


def _finest_classes(scene: Scene, cells: Any) -> str:
    for kind in reversed(CLASSES):
        try:
            resampled(with_encoding(scene, kind), tuple(cells))
        except UserError:
            continue
        return kind
    return CLASSES[0]


def _coinciding(cells: Any, fine: Any) -> Any:
    """The node of the fine grid at each node of a coarser one, shape (n,)."""
    steps = np.indices(tuple(cells[::-1] + 1)).reshape(len(cells), -1) * (fine // cells)[::-1, None]
    return np.ravel_multi_index(tuple(steps), tuple(fine[::-1] + 1))


def _unknowns(cells: Any) -> int:
    return int(np.prod(cells + 1)) * len(cells)


def _largest(scene: Scene) -> int:
    """Unknowns that the reference may have."""
    assert isinstance(scene.reference, FemTable)
    if scene.load_cases.times is not None:
        return LARGEST_MOTION
    if scene.reference.law != "linear":
        return LARGEST_STRAIN
    assert isinstance(scene.lattice, GridTable)
    return LARGEST_FLAT if len(scene.lattice.grid) == 2 else LARGEST_SOLID


def _absent(factor: Fraction, whole: list[Fraction]) -> str:
    return "its reference would be too large" if factor in whole else "the cells can't be halved"
