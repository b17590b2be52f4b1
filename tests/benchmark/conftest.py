"""Small scenes and jobs on them."""

from collections.abc import Callable
from pathlib import Path

import pytest

from springopt.benchmark import Job
from springopt.scene import Scene, load_scene

NINE = (Path(__file__).parents[1] / "data" / "nine-nodes.toml").read_text()
BITS = NINE.replace('"real"\nlower = 0.0\nupper = 10.0\nthreshold = 0.5', '"binary"\nstiffness = 5.0')


@pytest.fixture
def nine(tmp_path) -> Scene:
    (tmp_path / "nine.toml").write_text(NINE)
    return load_scene(tmp_path / "nine.toml")


@pytest.fixture
def bits(tmp_path) -> Scene:
    (tmp_path / "bits.toml").write_text(BITS)
    return load_scene(tmp_path / "bits.toml")


@pytest.fixture
def job() -> Callable[..., Job]:
    """A job on a scene, by default of random search."""

    def make(scene: Scene, optimizer: str = "random-search", seed: int = 0, **rest) -> Job:
        return Job(scene=scene.to_json(), scene_name=scene.name, optimizer=optimizer, seed=seed, **rest)

    return make
