"""The scale of an objective: from a start that needs no search down to the floor, as far as either is known."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from springopt.analysis.analytic_start import analytic_start
from springopt.analysis.floor import sampled_value
from springopt.analysis.known_floor import Floor, stored_floors
from springopt.analysis.way import Way
from springopt.scene import Setup
from springopt.scene.bundled import scene_file
from springopt.tradeoff.axes.optimizer.runs import Attempt


def way_of(setup: Setup, attempts: Sequence[Attempt], lowest_before: float = np.inf) -> Way:
    """Start and floor of a scene: the stored ones, else the analytic start and the lowest value of these runs.

    A stored floor that a run went below gives way to that run's value, and any to a lower one of runs before these.
    """
    scene = setup.scene
    stored = next((each for each in stored_floors(scene.name, [Path()]) if each.digest == scene.digest()), None)
    start, start_is = _start(setup, stored)
    floor, notes = _floor(scene.name, attempts, stored)
    floor = min(floor, lowest_before)
    if start <= floor:
        notes.append(f"{start_is[0].upper()}{start_is[1:]} is not above the floor: errors are differences of values.")
    return Way(start, start_is, floor, stored is not None and stored.proof is not None, tuple(notes))


def resolution(setup: Setup, way: Way) -> float:
    """The gap that the forward solve can't tell from zero: its tolerance, beside the value of a body at rest."""
    objective = setup.objective
    is_training = [case.role == "train" for case in objective.cases]
    displacements = (objective.reference_positions - setup.lattice.nodes)[is_training]
    roots = np.sqrt(np.asarray(objective.weights)[is_training])
    at_rest = objective.value_of((displacements.reshape(len(roots), -1) * roots[:, None]).ravel())
    degree = 2 if objective.minimize == "least-squares" else 1
    return max(at_rest * objective.tolerance**degree / way.length, np.finfo(float).eps)


def _start(setup: Setup, stored: Floor | None) -> tuple[float, str]:
    if stored is not None and stored.start is not None:
        return stored.start, stored.start_said
    start = analytic_start(setup)
    return (sampled_value(setup), "the median of random samples") if start is None else (start[1], "the analytic start")


def _floor(scene: str, attempts: Sequence[Attempt], stored: Floor | None) -> tuple[float, list[str]]:
    runs = [(attempt.run.objective, attempt) for attempt in attempts if attempt.run is not None]
    if not runs:
        return (0.0 if stored is None else stored.value), []
    lowest, best = min(runs, key=lambda pair: pair[0])
    file = scene if scene_file(scene) else f"{scene}.toml"
    if stored is None:
        return lowest, [
            f"No floor of {scene} is stored here: its place is taken by {lowest:.9g}, the lowest value of these runs "
            f"({best.optimizer}, seed {best.seed}), whose own errors are 0 for that reason; springopt floor {file} "
            "looks for one."
        ]
    if stored.is_beaten_by(lowest):
        return lowest, [
            f"{best.optimizer}, seed {best.seed}, went below the floor of {scene}, {stored.value:.9g}: the floor "
            f"here is its {lowest:.9g}; springopt floor {file} looks for it again."
        ]
    return min(stored.value, lowest), []
