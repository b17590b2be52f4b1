"""Strangers' packages are built from their folders, installed beside the project, and found by entry points alone."""

import json
import os
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

EXAMPLES = Path(__file__).parents[1] / "examples"
FLOORS = EXAMPLES / "third_party_scenes" / "bridge_scenes" / "floors"
MAIN = "from springopt.cli import main; main()"


def installed(folder: Path, home: Path) -> Callable[..., Any]:
    """The command in a process of its own, for which a package is installed; gives what `--json` prints."""
    build = [sys.executable, "-m", "hatchling", "build", "--target", "wheel", "--directory", str(home)]
    subprocess.run(build, cwd=folder, check=True, capture_output=True)
    (wheel,) = home.glob("*.whl")
    zipfile.ZipFile(wheel).extractall(home / "site-packages")  # which is all that installing pure Python is
    paths = [str(home / "site-packages"), *filter(None, [os.environ.get("PYTHONPATH")])]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(paths)}

    def command(*arguments: str) -> Any:
        words = [sys.executable, "-c", MAIN, *arguments, "--json"]
        done = subprocess.run(words, cwd=home, env=environment, check=True, capture_output=True, text=True)
        return json.loads(done.stdout)

    return command


@pytest.fixture(scope="module")
def with_optimizer(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Any]:
    return installed(EXAMPLES / "third_party_optimizer", tmp_path_factory.mktemp("optimizer"))


@pytest.fixture(scope="module")
def with_scenes(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Any]:
    return installed(EXAMPLES / "third_party_scenes", tmp_path_factory.mktemp("scenes"))


@pytest.fixture(scope="module")
def with_effect(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Any]:
    return installed(EXAMPLES / "third_party_effect", tmp_path_factory.mktemp("effect"))


class TestOptimizer:
    def test_it_is_listed_with_its_distribution_and_its_options(self, with_optimizer: Callable[..., Any]) -> None:
        entry = next(entry for entry in with_optimizer("list", "optimizers") if entry["name"] == "compass-search")
        assert entry["distribution"] == "compass-search"
        assert [option["name"] for option in entry["options"]] == ["first", "last"]

    def test_it_keeps_the_contract(self, with_optimizer: Callable[..., Any]) -> None:
        assert with_optimizer("check-plugin", "compass-search")["passed"]

    def test_it_solves_a_scene(self, with_optimizer: Callable[..., Any]) -> None:
        order = ("--optimizer", "compass-search", "--set", "first=0.2", "--evaluations", "300")
        run = with_optimizer("solve", "paper-fem-2d-two-class", *order)
        assert (run["optimizer"], run["options"]["first"], run["evaluations"]) == ("compass-search", 0.2, 300)
        assert run["objective"] < 0.2


SOFT_GROUND = """
extends = "paper-fem-2d-4"
title = "On soft ground"
[[effects]]
kind = "foundation"
"""


class TestEffect:
    def test_it_is_listed_with_its_distribution_what_it_brings_and_its_options(
        self, with_effect: Callable[..., Any]
    ) -> None:
        entry = next(entry for entry in with_effect("list", "effects") if entry["name"] == "foundation")
        assert (entry["distribution"], entry["brings"]) == ("springopt-foundation", ["a potential"])
        assert [option["name"] for option in entry["options"]] == ["modulus", "sides"]

    def test_it_keeps_the_contract(self, with_effect: Callable[..., Any]) -> None:
        assert with_effect("check-plugin", "foundation", "--set", "modulus=2", "--set", "sides=bottom,left")["passed"]

    def test_a_scene_is_solved_on_it(self, with_effect: Callable[..., Any], tmp_path: Path) -> None:
        (tmp_path / "soft.toml").write_text(SOFT_GROUND + "modulus = 2.0\n", encoding="utf-8")
        explained = with_effect("explain", str(tmp_path / "soft.toml"))
        assert [effect["name"] for effect in explained["effects"]] == ["springs", "foundation"]
        order = ("--optimizer", "random-search", "--evaluations", "20")
        assert with_effect("solve", str(tmp_path / "soft.toml"), *order)["evaluations"] == 20

    def test_its_options_are_checked_like_those_of_the_core(
        self, with_effect: Callable[..., Any], tmp_path: Path
    ) -> None:
        (tmp_path / "soft.toml").write_text(SOFT_GROUND + "modulos = 2.0\n", encoding="utf-8")
        with pytest.raises(subprocess.CalledProcessError) as caught:
            with_effect("explain", str(tmp_path / "soft.toml"))
        fault = "effects[0].modulos is not an option of foundation; remove it. Did you mean 'modulus'?"
        assert fault in caught.value.stderr


class TestScenes:
    def test_they_are_listed_with_their_group_and_distribution(self, with_scenes: Callable[..., Any]) -> None:
        (entry,) = [entry for entry in with_scenes("list", "scenes") if entry["distribution"] != "springopt"]
        assert (entry["name"], entry["group"], entry["distribution"]) == ("worn-bridge", "bridges", "bridge-scenes")
        assert with_scenes("list", "scenes", "bridges") == [entry]

    def test_a_run_on_one_finds_its_floor(self, with_scenes: Callable[..., Any]) -> None:
        run = with_scenes("solve", "worn-bridge", "--optimizer", "random-search", "--evaluations", "20")
        assert run["scene"] == "worn-bridge"
        assert (run["floor"]["value"], run["floor"]["proven"]) == (0.0, True)

    def test_its_floor_is_computed_and_stored_where_the_package_lies(self, with_scenes: Callable[..., Any]) -> None:
        floor = with_scenes("floor", "worn-bridge")
        stored = Path(floor.pop("file"))
        assert stored.parts[-4:] == ("site-packages", "bridge_scenes", "floors", "worn-bridge.json")
        assert json.loads(stored.read_text(encoding="utf-8")) == floor
        shipped = json.loads((FLOORS / "worn-bridge.json").read_text(encoding="utf-8"))
        assert (shipped["digest"], shipped["value"], shipped["proof"]) == (floor["digest"], 0.0, floor["proof"])
