"""Where a run's value lies between the start and the floor of its scene, if they are stored."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from springopt.analysis.known_floor import Floor
    from springopt.run import Run


@dataclass(frozen=True)
class Place:
    """A run's value beside its scene's floor."""

    floor: Floor | None
    said: str | None  #: one line; None where nothing is stored


def place_of(run: Run, folders: Sequence[Path]) -> Place:
    """Looks for the scene's floor in the package and in these folders."""
    from springopt.analysis.known_floor import stored_floors

    stored = stored_floors(run.scene, folders)
    if not stored:
        return Place(None, None)
    floor = next((each for each in stored if each.digest == run.scene_digest), None)
    if floor is None:
        hint = "the floor that is stored belongs to another state of this scene; springopt floor computes a new one"
        return Place(None, hint)
    return Place(floor, _say(floor, run))


def with_floor(run: Run, place: Place) -> str:
    """The run as one JSON document, with the floor and the share of the way to it."""
    document = json.loads(run.to_json())
    floor = place.floor
    document["floor"] = floor and {
        "value": floor.value,
        "proven": floor.proof is not None,
        "analytic": floor.analytic,
        "sampled": floor.sampled,
        "fraction": floor.fraction(run.objective),
    }
    return json.dumps(document)


def _say(floor: Floor, run: Run) -> str:
    if floor.is_beaten_by(run.objective):
        said = f"below {floor.value:.9g}, the lowest value known so far"
        return f"{said}; store it with springopt floor {_scene(run)} --from {run.run}" if run.run else said
    if floor.start is not None and run.objective > floor.start:
        return f"worse than {floor.start_said} {floor.start:.6g}; the floor is {floor.said}"
    fraction = floor.fraction(run.objective)
    if fraction is not None:
        return f"{100 * fraction:.4g} % of the way from {floor.start_said} {floor.start:.6g} to the floor {floor.said}"
    if floor.value == 0:
        return f"the floor is {floor.said}"
    return f"{100 * (run.objective / floor.value - 1):.3g} % above the floor {floor.said}"


def _scene(run: Run) -> str:
    from springopt.scene import bundled_scenes

    return run.scene if run.scene in bundled_scenes() else f"{run.scene}.toml"
