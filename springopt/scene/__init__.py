"""Scenes: the TOML files that state everything, read, checked and built."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from springopt.scene.bundled import SceneHead, bundled_scenes

if TYPE_CHECKING:
    from springopt.scene.build import Setup
    from springopt.scene.load import load_scene
    from springopt.scene.schema import Scene

__all__ = ["Scene", "SceneHead", "Setup", "bundled_scenes", "load_scene"]

_HOMES = {"Scene": "schema", "Setup": "build", "load_scene": "load"}


def __getattr__(name: str) -> Any:
    """Imports pydantic and the numerics only when a scene is read, not when scenes are listed."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
