"""Runs for comparing: made by hand, or by random search on a small scene."""

import shutil
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from springopt.comparison.record import Record
from springopt.random_search import RandomSearch
from springopt.runner import solve
from springopt.scene import Scene, load_scene

NINE = (Path(__file__).parents[1] / "data" / "nine-nodes.toml").read_text()


@pytest.fixture
def record() -> Callable[..., Record]:
    """A run made by hand: (evaluations, value) of its improvements; two solves and a second for each evaluation."""

    def make(improvements: Sequence[tuple[int, float]], total: int = 100, **changes: Any) -> Record:
        counts, values = np.array(improvements, dtype=float).T
        facts: dict[str, Any] = {
            "path": Path("run.h5"),
            "scene": "by hand",
            "digest": "1",
            "tests": "1",
            "minimize": "distance",
            "label": changes.get("method", "a"),
            "method": "a",
            "optimizer": "a",
            "seed": 0,
            "options": {},
            "start": None,
            "budget": {"evaluations": 100},
            "processor": "one",
            "build": {"numpy": "2.0"},
            "values": values,
            "spent": {"evaluations": counts, "solves": 2 * counts, "processor_seconds": counts},
            "total": {"evaluations": total, "solves": 2 * total, "processor_seconds": total},
            "solving_seconds": 0.75 * total,
            "train_error": 0.1,
            "test_error": 0.2,
            "why_stopped": "budget",
        }
        return Record(**facts | changes)

    return make


@pytest.fixture(scope="session")
def nine(tmp_path_factory: pytest.TempPathFactory) -> Scene:
    path = tmp_path_factory.mktemp("scene") / "nine.toml"
    path.write_text(NINE)
    return load_scene(path)


@pytest.fixture(scope="session")
def nine_results(nine: Scene, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Results of two methods on one scene, three seeds each; a third is refused there."""
    results = tmp_path_factory.mktemp("nine") / "results"
    for label, batch in {"wide": 8, "narrow": 2}.items():
        for seed in range(3):
            run(results, nine, label, batch, seed)
    refused = results / "nine" / "stubborn" / "refused.json"
    refused.parent.mkdir()
    refused.write_text('{"word": "bits", "sentence": "stubborn needs bits; choose another optimizer."}')
    return results


@pytest.fixture
def folder(nine_results: Path, tmp_path: Path) -> Path:
    """A copy of these results, to do with as a test likes."""
    return shutil.copytree(nine_results, tmp_path / "results")


@pytest.fixture
def add_run(nine: Scene, folder: Path) -> Callable[..., Path]:
    """Adds a run to the folder of results."""

    def add(label: str, batch: int, seed: int, evaluations: int = 16, scene: Scene = nine) -> Path:
        return run(folder, scene, label, batch, seed, evaluations)

    return add


def run(results: Path, scene: Scene, label: str, batch: int, seed: int, evaluations: int = 16) -> Path:
    """Random search, with its place in a folder of results."""
    out = results / scene.name / label / f"seed{seed}.h5"
    out.parent.mkdir(parents=True, exist_ok=True)
    solve(scene, RandomSearch(batch=batch), seed=seed, evaluations=evaluations, out=out)
    return out


@pytest.fixture
def two_scenes(folder: Path, add_run: Callable[..., Path], tmp_path: Path) -> Path:
    """The same with a second scene, for which the first one's stiffness is too high."""
    (tmp_path / "soft.toml").write_text(NINE.replace("stiffness = 5.0", "stiffness = 1.0"))
    for label, batch in {"wide": 8, "narrow": 2}.items():
        add_run(label, batch, 0, scene=load_scene(tmp_path / "soft.toml"))
    return folder
