"""What counts as solved: targets on the way from a scene's start to its floor."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from springopt.analysis.known_floor import Floor, stored_floors
from springopt.analysis.way import Way
from springopt.checks import Floats
from springopt.comparison.record import Record
from springopt.scene.bundled import scene_file

#: Targets, as negative powers of ten of the way from the start to the floor.
TARGETS = (1, 2, 3, 4, 5, 6)

#: Gaps up to the last target are equal: whoever is there has solved the scene, near the forward solve's tolerance.
SOLVED = 10.0 ** -TARGETS[-1]


def way_of(records: Sequence[Record], folders: Sequence[Path]) -> Way:
    """Start and floor of the scene that all these records are of.

    A floor that a run went below is replaced by that run's value, and a missing one by the lowest value of these runs.

    Args:
        folders: where floors of scenes may lie that are not bundled.
    """
    first, best = records[0], min(records, key=lambda record: record.value)
    stored = next((each for each in stored_floors(first.scene, folders) if each.digest == first.digest), None)
    start, start_is, notes = _start(records, stored)
    floor, more = _floor(best, stored)
    notes += more
    if start <= floor:
        notes.append(f"the start of {first.scene} is not above its floor: gaps there are differences of values.")
    return Way(start, start_is, floor, stored is not None and stored.proof is not None, tuple(notes))


def _start(records: Sequence[Record], stored: Floor | None) -> tuple[float, str, list[str]]:
    """The stored start, what it is, and what to know of it; where there is none, what the runs began with."""
    if stored is not None and stored.start is not None:
        return stored.start, stored.start_said, []
    first, scene = float(np.median([record.values[0] for record in records])), records[0].scene
    note = f"no start of {scene} is stored: its place is taken by the median first value, {first:.6g}."
    return first, "the median first value of these runs", [note]


def _floor(best: Record, stored: Floor | None) -> tuple[float, list[str]]:
    scene, name = best.scene, best.scene if scene_file(best.scene) else f"{best.scene}.toml"
    if stored is None:
        note = (
            f"no floor of {scene} is stored: its place is taken by {best.value:.9g}, the lowest value of these runs "
            f"({best.method}, seed {best.seed}); springopt floor {name} looks for one."
        )
    elif stored.is_beaten_by(best.value):
        note = (
            f"{best.method}, seed {best.seed}, went below the floor of {scene}, {stored.value:.9g}: the floor here is "
            f"its {best.value:.9g}; springopt floor {name} --from {best.path} stores it."
        )
    else:
        return min(stored.value, best.value), []
    return best.value, [note]


def clipped(gaps: Floats) -> Floats:
    """Gaps as they are ranked and tested: what has solved the scene is equal."""
    return np.maximum(gaps, SOLVED)
