"""From a TOML file, and what it extends, to a checked scene."""

from __future__ import annotations

import json
import os
import tomllib
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError

from springopt.errors import SceneError, UserError, did_you_mean
from springopt.lattice import SpringLattice
from springopt.scene.bundled import bundled_scenes, scene_file
from springopt.scene.faults import explain, scene_error
from springopt.scene.lattice_tables import LatticeTable, MeshTable, NodesTable
from springopt.scene.schema import Scene


def load_scene(path_or_name: str | os.PathLike[str]) -> Scene:
    """The scene of a TOML file, or the scene of this name, bundled or brought by another distribution.

    Raises:
        SceneError: with all faults of the scene at once, each with its path.
    """
    data = _read(path_or_name, folder=Path(), extending=())
    data.setdefault("name", Path(path_or_name).name.removesuffix(".toml"))
    return check(data, source=str(path_or_name))


def read_json(text: str) -> Scene:
    """The scene that `Scene.to_json` wrote."""
    data = json.loads(text)
    return check(data, source=str(data.get("name")))


def check(data: dict[str, Any], source: str) -> Scene:
    """A scene of its tables; a lattice read from a mesh file is written out in it."""
    lattice, lattice_faults = _lattice(data.get("lattice"))
    try:
        scene = Scene.model_validate(data, context={"lattice": lattice})
    except ValidationError as error:
        raise scene_error(source, lattice_faults + explain(error, Scene)) from None
    if lattice is None:
        raise scene_error(source, lattice_faults)
    if isinstance(scene.lattice, MeshTable):
        return scene.model_copy(update={"lattice": NodesTable.of(lattice)})
    return scene


def _lattice(table: Any) -> tuple[SpringLattice | None, list[str]]:
    """The lattice and no fault, or no lattice and the faults that its types do not show."""
    try:
        return TypeAdapter(LatticeTable).validate_python(table).build(), []
    except ValidationError:
        return None, []
    except UserError as error:
        return None, [f"lattice: {error}"]


def _read(path_or_name: str | os.PathLike[str], folder: Path, extending: tuple[str, ...]) -> dict[str, Any]:
    """The tables of a scene over those of the scene that it extends."""
    name, text, folder = _find(path_or_name, folder)
    if name in extending:
        raise SceneError(f"scene {name} extends itself by way of {' and '.join(extending)}; break the circle.")
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise SceneError(f"scene {name} is not valid TOML: {error}; mend that line.") from None
    lattice = data.get("lattice")
    if isinstance(lattice, dict) and isinstance(lattice.get("mesh"), str):
        lattice["mesh"] = str(folder / lattice["mesh"])
    if "extends" not in data:
        return data
    base = data.pop("extends")
    if not isinstance(base, str):
        raise SceneError(f"scene {name}: extends should be the name or the path of a scene, but is {base!r}.")
    inherited = _read(base, folder, (*extending, name))
    for own in ("name", "group"):
        inherited.pop(own, None)
    return merge(inherited, data)


def _find(path_or_name: str | os.PathLike[str], folder: Path) -> tuple[str, str, Path]:
    """Identity, text and folder of a scene: of a file where it looks like a path, else of the scene of this name."""
    name = os.fspath(path_or_name)
    if not isinstance(path_or_name, str) or name.endswith(".toml") or os.sep in name:
        path = (folder / name).resolve()
        try:
            return str(path), path.read_text(encoding="utf-8"), path.parent
        except (OSError, UnicodeDecodeError) as error:
            reason = getattr(error, "strerror", None) or "it is not UTF-8 text"
            raise SceneError(f"scene {name} can't be read ({reason}); give the path of a TOML file.") from None
    file = scene_file(name)
    if file is None:
        raise SceneError(
            f"there is no scene {name!r}.{did_you_mean(name, bundled_scenes())} "
            "`springopt list scenes` names them; a file of your own ends in .toml."
        )
    return name, file.read_text(encoding="utf-8"), Path(str(file)).parent


def merge(base: dict[str, Any], over: dict[str, Any]) -> dict[str, Any]:
    """Tables merged key by key, everything else replaced; a table of another kind replaces the whole table."""
    merged = dict(base)
    for key, value in over.items():
        below = base.get(key)
        if isinstance(value, dict) and isinstance(below, dict) and _same_kind(below, value):
            merged[key] = merge(below, value)
        else:
            merged[key] = value
    return merged


def _same_kind(base: dict[str, Any], over: dict[str, Any]) -> bool:
    """Tables say their kind, and a lattice shows it by its main key."""
    says_other = "kind" in over and over["kind"] != base.get("kind")
    return not says_other and all(key in base for key in ("grid", "mesh", "nodes") if key in over)
