"""Test modules here share a small scene, and what may happen to a run on it."""

import sys
from pathlib import Path

import pytest

from springopt import runner
from springopt.random_search import RandomSearch
from springopt.scene import load_scene

sys.path.insert(0, str(Path(__file__).parent))
from nine_nodes import SCENE, Wanderer


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "nine.toml"
    path.write_text(SCENE)
    return load_scene(path)


@pytest.fixture
def out(tmp_path):
    folder = tmp_path / "out"
    folder.mkdir()
    return folder / "run.h5"


@pytest.fixture
def wanderer(monkeypatch):
    monkeypatch.setattr(runner, "load_optimizer", {"wanderer": Wanderer, "random-search": RandomSearch}.__getitem__)
    return Wanderer()


@pytest.fixture
def eager_progress(monkeypatch):
    """Progress at every solve, not only ten times a second."""
    monkeypatch.setattr("springopt.execution.PROGRESS_SECONDS", 0.0)
