"""The point of an encoding's box at which something is asked, with a sentence that says which."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from springopt.analysis.analytic_start import analytic_start
from springopt.checks import Floats
from springopt.errors import UserError
from springopt.reference.spring import SpringReference
from springopt.scene import Setup

PLACES = ("best", "reference", "start", "middle")


@dataclass(frozen=True, eq=False)
class Point:
    """A point of the box, shape (size,), and which one it is."""

    numbers: Floats
    said: str  #: as in "at the reference's stiffness"


def choose_point(setup: Setup, place: str | None = None, best: Floats | None = None) -> Point:
    """The point that a place names; by default the best of a run, else the reference's, else the middle of the box.

    Args:
        setup: the scene.
        place: one of `PLACES`.
        best: the best point of a run, shape (size,), if there is one.
    """
    reference = reference_stiffness(setup)
    place = place or ("best" if best is not None else "middle" if reference is None else "reference")
    if place == "best":
        if best is None:
            raise UserError("the best point is a run's, and a scene has none; give RUN.h5, or another place.")
        return Point(best, "at the best point of the run")
    if place == "reference":
        if reference is None:
            raise UserError(
                "the reference has a stiffness where it is a mass-spring model, and this scene's is none; "
                "leave out --at reference."
            )
        return _at_reference(setup, reference)
    if place == "start":
        return _at_start(setup)
    if setup.encoding.kind == "binary":
        return Point(setup.encoding.upper, "with all springs present, as no better point is known")
    middle = (setup.encoding.lower + setup.encoding.upper) / 2
    return Point(middle, "in the middle of the box, as no better point is known")


def reference_stiffness(setup: Setup) -> Floats | None:
    """Stiffness of a mass-spring reference [force/length], shape (s,); None where the reference is no such model."""
    reference = setup.objective.reference
    return reference.stiffness if isinstance(reference, SpringReference) else None


def encode(setup: Setup, stiffness: Floats) -> tuple[Floats, bool]:
    """The point closest to a stiffness, shape (s,), with effects as they are stated, and whether it is exactly that."""
    terms = setup.model.terms
    row = np.concatenate([stiffness, terms.defaults[terms.fitted_columns]])
    point = setup.encoding.encode(row)
    return point, bool(np.allclose(setup.encoding.decode(point), row, rtol=1e-12, atol=0.0))


def _at_start(setup: Setup) -> Point:
    start = analytic_start(setup)
    if start is None:
        raise UserError(
            "the analytic start is that of the optimizer 'analytic', which is not installed or has no formula for this "
            "scene; install springopt-analytic, or choose another place."
        )
    return Point(start[0], "at the analytic start")


def _at_reference(setup: Setup, stiffness: Floats) -> Point:
    point, is_exact = encode(setup, stiffness)
    closest = "at the point of the encoding closest to the reference's stiffness, which it can't express"
    return Point(point, "at the reference's stiffness" if is_exact else closest)
