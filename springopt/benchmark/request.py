"""What was asked of a folder of results: written beside them, so that another call adds to it or is refused."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from springopt.benchmark.outcome import write_json
from springopt.budget import Budget
from springopt.errors import UserError
from springopt.origin import this_origin
from springopt.registry import load_optimizer
from springopt.scene import Scene

REQUEST = "benchmark.json"
FORMAT = 1


@dataclass(frozen=True)
class Request:
    """What is asked of a folder of results now, beside what was asked before."""

    path: Path
    document: Mapping[str, Any]
    is_noted: bool  #: an earlier call asked for the same
    is_of_another_build: bool  #: than an earlier call

    def note(self) -> None:
        """Writes it down in the folder."""
        if not self.is_noted:
            write_json(self.path, dict(self.document))


def make_request(
    folder: Path, scenes: Sequence[Scene], optimizers: Sequence[str], seeds: int, limits: Mapping[str, float]
) -> Request:
    """What is asked of the folder; nothing is written yet.

    Raises:
        UserError: where runs are there on another state of a scene, or with another budget: they could not be compared.
    """
    path = folder / REQUEST
    written = _read(path)
    asked = {scene.name: {"digest": scene.digest_with_tests(), "budget": _budget(scene, limits)} for scene in scenes}
    for name, facts in asked.items():
        _require_unchanged(folder, name, written["scenes"].get(name, facts), facts)
    versions = {name: this_origin(load_optimizer(name)) for name in optimizers}
    request = {
        "scenes": list(asked),
        "optimizers": list(optimizers),
        "seeds": seeds,
        "versions": versions,
    }
    earlier: list[dict[str, Any]] = written["requests"]
    document = {
        "format": FORMAT,
        "scenes": written["scenes"] | asked,
        "requests": earlier if request in earlier else [*earlier, request],
    }
    is_of_another_build = any(_differ(versions, each["versions"]) for each in earlier)
    return Request(path, document, document == written, is_of_another_build)


def _budget(scene: Scene, limits: Mapping[str, float]) -> dict[str, float]:
    """The limits that hold for a scene, without those that are not set."""
    given: dict[str, Any] = dict(limits) or scene.budget.model_dump()
    budget = Budget(**given)
    return {name: limit for name, limit in vars(budget).items() if limit is not None}


def _require_unchanged(folder: Path, scene: str, before: Mapping[str, Any], now: Mapping[str, Any]) -> None:
    place = folder / scene
    if before["digest"] != now["digest"] and any(place.glob("*/*")):
        raise UserError(f"{folder} has runs on another state of scene {scene}; choose another folder.")
    if before["budget"] != now["budget"] and any(place.glob("*/seed*.h5*")):  # a refusal has no budget
        raise UserError(
            f"{folder} has runs on {scene} with a budget of {_say(before['budget'])}, and now it is "
            f"{_say(now['budget'])}; choose another folder."
        )


def _say(budget: Mapping[str, float]) -> str:
    return ", ".join(f"{limit:g} {name}" if name != "target" else f"target {limit:g}" for name, limit in budget.items())


def _require_form(written: Mapping[str, Any]) -> None:
    """Uses whatever is used later, so that a damaged document is told here."""
    for facts in written["scenes"].values():
        str(facts["digest"])
        _say(facts["budget"])
    for request in written["requests"]:
        _differ(request["versions"], request["versions"])


def _differ(versions: Mapping[str, Any], others: Mapping[str, Any]) -> bool:
    """Whether an optimizer that both know ran on another build."""
    return any(versions[name] != others[name] for name in versions.keys() & others.keys())


def _read(path: Path) -> dict[str, Any]:
    if not path.exists():
        return {"scenes": {}, "requests": []}
    try:
        written: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        made = int(written["format"])
        _require_form(written)
    except (OSError, ValueError, LookupError, TypeError, AttributeError) as error:
        raise UserError(f"{path} can't be read ({type(error).__name__}: {error}); choose another folder.") from None
    if made > FORMAT:
        raise UserError(f"{path} has format {made}, and this springopt knows up to {FORMAT}; use a newer springopt.")
    return written
