"""The scenes that have a name: those bundled with springopt, and those that other distributions bring.

A distribution names a package in the entry point group `springopt.scenes`: its folder holds scenes as TOML files, and
their floors below `floors`. Needs the standard library alone.
"""

from __future__ import annotations

import re
import tomllib
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.metadata import EntryPoint, entry_points
from importlib.resources import files
from importlib.resources.abc import Traversable

GROUP = "springopt.scenes"
BUNDLED = "springopt"
#: Groups of scenes in the order in which they are listed, before those of other distributions.
SCENE_GROUPS = ("paper", "recovery", "fem-2d", "fem-3d", "scale", "hard")


@dataclass(frozen=True)
class SceneHead:
    """What a list says of a scene."""

    name: str
    title: str
    group: str | None  #: of scenes that ask the same of an optimizer
    distribution: str  #: that brings it


def bundled_scenes() -> dict[str, SceneHead]:
    """Every scene that has a name, by this name, group by group.

    A distribution whose scenes can't be listed is left out, and so is a scene whose name is taken, with a warning.
    """
    heads: dict[str, SceneHead] = {}
    for distribution, folder in _folders():
        for head in _heads(distribution, folder):
            owner = heads.setdefault(head.name, head).distribution
            if owner != distribution:
                _warn(f"scene {head.name} of {distribution} is left out, as {owner} has one of that name; rename it.")
    return {head.name: head for head in sorted(heads.values(), key=_place)}


def scene_file(name: str) -> Traversable | None:
    """The TOML file of the scene of this name; None where there is none. No other scene is read."""
    return next((file for _, folder in _folders() for file in _files(folder) if _name(file) == name), None)


def _folders() -> Iterator[tuple[str, Traversable]]:
    """Distributions and the folders of their scenes: the bundled ones, then others in the order of the alphabet."""
    yield BUNDLED, files("springopt.scene") / "scenes"
    for entry in sorted(entry_points(group=GROUP), key=_distribution):
        try:
            folder = files(entry.value)
        except Exception as error:  # a stranger's package may raise anything while it is imported
            _warn_of(_distribution(entry), error)
            continue
        yield _distribution(entry), folder


def _heads(distribution: str, folder: Traversable) -> list[SceneHead]:
    try:
        return [_head(distribution, file) for file in _files(folder)]
    except (OSError, ValueError) as error:
        _warn_of(distribution, error)
        return []


def _head(distribution: str, file: Traversable) -> SceneHead:
    table = tomllib.loads(file.read_text(encoding="utf-8"))
    title, group = table.get("title"), table.get("group")
    if not isinstance(title, str) or not isinstance(group, str | None):
        raise ValueError(f"{file.name} should have a title, and its group should be a word")
    return SceneHead(_name(file), title, group, distribution)


def _files(folder: Traversable) -> list[Traversable]:
    return [entry for entry in folder.iterdir() if entry.name.endswith(".toml")]


def _name(file: Traversable) -> str:
    return file.name.removesuffix(".toml")


def _place(head: SceneHead) -> tuple[int, str, list[str | int]]:
    """By group, then by name, in which numbers count as numbers."""
    group = head.group or "~"  # after all that have one
    rank = SCENE_GROUPS.index(group) if group in SCENE_GROUPS else len(SCENE_GROUPS)
    return rank, group, [int(part) if part.isdigit() else part for part in re.split(r"(\d+)", head.name)]


def _distribution(entry: EntryPoint) -> str:
    return entry.dist.name if entry.dist else "an unknown distribution"


def _warn_of(distribution: str, error: Exception) -> None:
    _warn(
        f"the scenes of {distribution} can't be listed ({type(error).__name__}: {error}); "
        "mend or uninstall that distribution."
    )


def _warn(sentence: str) -> None:
    warnings.warn(sentence, RuntimeWarning, stacklevel=2)
