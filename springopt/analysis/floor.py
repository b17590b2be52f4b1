"""The floor of a scene: the lowest value of its own misfit that can be found, with its evidence.

Where a mass-spring reference lies in the encoding's set the floor is zero, and that is proven: a misfit is never
negative. Otherwise it is the best known, which `floor_search` looks for.
"""

from __future__ import annotations

from importlib.metadata import version
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from springopt.analysis.analytic_start import analytic_start
from springopt.analysis.floor_search import Found, Progress, search_bits, search_box
from springopt.analysis.known_floor import Floor
from springopt.analysis.point import encode, reference_row
from springopt.checks import Floats
from springopt.errors import UserError
from springopt.forward.status import has_equilibrium
from springopt.scene import Setup

STARTS = 20
SAMPLES = 101  # whose median is the start where there is no formula for one
#: A proven zero is reached to this, in smallest rest lengths: what the tolerances of two forward solves leave.
REACHED = 1e-6


def compute_floor(setup: Setup, *, starts: int = STARTS, seed: int = 0, progress: Progress | None = None) -> Floor:
    """The floor of a scene, not yet stored.

    Args:
        setup: the scene.
        starts: how many, at least 1.
        seed: of the starts' sampling.
        progress: called after each descent.
    """
    if starts < 1:
        raise UserError(f"a floor needs at least 1 start, not {starts}; give another number.")
    start = analytic_start(setup)
    zero = _zero(setup)
    if zero is not None:
        return _floor(setup, zero, start, proof="the reference is in the encoding's set, and no misfit is negative")
    search = search_bits if setup.encoding.kind == "binary" else search_box
    with threadpool_limits(1, user_api="blas"):  # more threads round differently
        rng, first = np.random.default_rng(seed), None if start is None else start[0]
        found = search(setup, starts, rng, first, progress or (lambda *_: None))
    return _floor(setup, found, start, evidence={"seed": seed})


def floor_at(setup: Setup, point: Floats, source: str) -> Floor:
    """The floor that a point found by other means makes: a run's, which `source` names."""
    value = float(setup.objective.evaluate(setup.encoding.decode(point)[None]).values[0])
    return _floor(setup, Found(point, value, {"method": source}), analytic_start(setup))


def _floor(
    setup: Setup,
    found: Found,
    start: tuple[Floats, float] | None,
    *,
    proof: str | None = None,
    evidence: dict[str, Any] | None = None,
) -> Floor:
    versions = {name: version(name) for name in ("springopt", "numpy", "scipy")}
    return Floor(
        scene=setup.scene.name,
        digest=setup.scene.digest(),
        minimize=setup.objective.minimize,
        value=found.value if proof is None else 0.0,
        proof=proof,
        reached=found.value,
        point=found.point.tolist() if proof is None else None,
        analytic=None if start is None else start[1],
        sampled=sampled_value(setup) if start is None else None,
        evidence=found.evidence | (evidence or {}) | versions,
    )


def sampled_value(setup: Setup) -> float:
    """The median value of random samples: of those that have an equilibrium, if any has one."""
    points = setup.encoding.sample(np.random.default_rng(0), SAMPLES)
    evaluation = setup.objective.evaluate(setup.encoding.decode(points))
    found = has_equilibrium(evaluation.codes)
    return float(np.median(evaluation.values[found] if found.any() else evaluation.values))


def _zero(setup: Setup) -> Found | None:
    """The point of a reference without noise, if the encoding has one and the forward solve agrees that it is right."""
    reference = reference_row(setup)
    if reference is None or setup.scene.reference.noise is not None:
        return None
    point, is_exact = encode(setup.encoding, reference)
    objective = setup.objective
    value = float(objective.evaluate(setup.encoding.decode(point)[None]).values[0])
    if not is_exact or value > REACHED * objective.smallest_rest_length * len(objective.cases):
        return None
    return Found(point, value, {"method": "the reference's stiffness", "evaluations": 1})
