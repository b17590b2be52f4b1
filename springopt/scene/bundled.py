"""The scenes that come with springopt; needs the standard library alone."""

from __future__ import annotations

import tomllib
from importlib.resources import files


def bundled_scenes() -> dict[str, str]:
    """Name and title of each bundled scene, by name."""
    return {name: tomllib.loads(text)["title"] for name, text in sorted(_texts().items())}


def bundled_text(name: str) -> str | None:
    """The TOML text of a bundled scene; None where there is none of this name."""
    return _texts().get(name)


def _texts() -> dict[str, str]:
    scenes = (entry for entry in (files("springopt.scene") / "scenes").iterdir() if entry.name.endswith(".toml"))
    return {entry.name.removesuffix(".toml"): entry.read_text(encoding="utf-8") for entry in scenes}
