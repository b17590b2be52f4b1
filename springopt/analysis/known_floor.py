"""The lowest value known of a scene, in the scene's own misfit, as it is stored: a JSON file beside the scene.

It holds for what decides the scene's values alone (`Scene.digest`): a scene that was changed has no floor until its own
is computed. Needs the standard library alone, because `solve` and `show` read it.
"""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from springopt.errors import UserError
from springopt.scene.bundled import scene_file

#: A value counts as lower than another one where it is so by this share.
LOWER = 1e-9


@dataclass(frozen=True, kw_only=True)
class Floor:
    """The lowest value known, where it is taken, and how it was found."""

    scene: str
    digest: str  #: of what decides the scene's values
    minimize: str  #: the misfit
    value: float
    proof: str | None  #: why no value is lower; None where it is only the best known
    reached: float  #: what the forward solve makes of the point, by its tolerance above a value of zero
    point: list[float] | None  #: None where it is the reference's stiffness, which the scene states
    analytic: float | None  #: value of the analytic start; None where there is none
    #: Median value of random samples; None where there is an analytic start.
    sampled: float | None = None
    evidence: dict[str, Any]

    @property
    def said(self) -> str:
        """The value and how sure it is."""
        return f"{self.value:.6g} ({'best known' if self.proof is None else 'proven'})"

    @property
    def start(self) -> float | None:
        """The value that a search has to improve on: the analytic start's, where there is none the samples'."""
        return self.sampled if self.analytic is None else self.analytic

    @property
    def start_said(self) -> str:
        """What the start is."""
        return "the median of random samples" if self.analytic is None else "the analytic start"

    def is_beaten_by(self, value: float) -> bool:
        return self.proof is None and value < self.value * (1 - LOWER)

    def fraction(self, value: float) -> float | None:
        """How much of the way from the start to the floor a value has gone; None without a start above the floor."""
        if self.start is None or self.start <= self.value:
            return None
        return (self.start - value) / (self.start - self.value)


def floor_file(scene: str) -> Path:
    """Where the floor of a scene is stored: beside its TOML file, of one that has a name in the package it is from."""
    file = None if scene.endswith(".toml") or os.sep in scene else scene_file(scene)
    if file is None:
        return Path(f"{scene.removesuffix('.toml')}.floor.json")
    return Path(str(file)).parent / "floors" / f"{scene}.json"


def stored_floors(name: str, folders: Sequence[Path]) -> list[Floor]:
    """What is stored for scenes of this name: in the package it is from, and in these folders."""
    paths = [floor_file(name), *(folder / f"{name}.floor.json" for folder in folders)]
    return [floor for path in paths if (floor := read_floor(path)) is not None]


def read_floor(path: Path) -> Floor | None:
    """The floor in a file; None where there is no such file."""
    try:
        return Floor(**json.loads(path.read_text(encoding="utf-8")))
    except FileNotFoundError:
        return None
    except (OSError, ValueError, TypeError) as error:
        raise UserError(f"{path} holds no floor ({error}); remove it, and compute the floor again.") from None


def store_floor(path: Path, found: Floor) -> Floor:
    """Stores a floor unless the one that is stored for the same scene is as low; the one that is stored then."""
    stored = read_floor(path)
    if stored is not None and stored.digest == found.digest and not _replaces(stored, found):
        found = replace(
            stored, analytic=_last(found.analytic, stored.analytic), sampled=_last(found.sampled, stored.sampled)
        )
    try:
        path.parent.mkdir(exist_ok=True)
        path.write_text(_written(found), encoding="utf-8")
    except OSError as error:
        raise UserError(
            f"the floor can't be stored in {path} ({error.strerror}); copy the scene to a folder of your own."
        ) from None
    return found


def _last(found: float | None, stored: float | None) -> float | None:
    return stored if found is None else found


def _replaces(stored: Floor, found: Floor) -> bool:
    return (found.proof is not None and stored.proof is None) or stored.is_beaten_by(found.value)


def _written(floor: Floor) -> str:
    """One line a fact."""
    facts = (f"  {json.dumps(name)}: {json.dumps(fact)}" for name, fact in asdict(floor).items())
    return "{\n" + ",\n".join(facts) + "\n}\n"
