"""Scenes that are written in the tests themselves."""

from collections.abc import Callable

import pytest

from springopt.scene import Scene, load_scene


@pytest.fixture(scope="session")
def scene_of(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Scene]:
    """The scene of a TOML text."""

    def load(text: str) -> Scene:
        path = tmp_path_factory.mktemp("scene") / "scene.toml"
        path.write_text(text, encoding="utf-8")
        return load_scene(path)

    return load
