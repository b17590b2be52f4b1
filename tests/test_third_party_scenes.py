"""A stranger's package of scenes is built from its folder, installed, and found by its entry point alone."""

import json
import os
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

FOLDER = Path(__file__).parents[1] / "examples" / "third_party_scenes"
MAIN = "from springopt.cli import main; main()"


@pytest.fixture(scope="module")
def springopt(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Any]:
    """The command in a process of its own, for which the package is installed; gives what `--json` prints."""
    home = tmp_path_factory.mktemp("third_party")
    build = [sys.executable, "-m", "hatchling", "build", "--target", "wheel", "--directory", str(home)]
    subprocess.run(build, cwd=FOLDER, check=True, capture_output=True)
    (wheel,) = home.glob("*.whl")
    zipfile.ZipFile(wheel).extractall(home / "site-packages")  # which is all that installing pure Python is
    environment = os.environ | {"PYTHONPATH": str(home / "site-packages")}

    def command(*arguments: str) -> Any:
        words = [sys.executable, "-c", MAIN, *arguments, "--json"]
        done = subprocess.run(words, cwd=home, env=environment, check=True, capture_output=True, text=True)
        return json.loads(done.stdout)

    return command


def test_they_are_listed_with_their_group_and_distribution(springopt: Callable[..., Any]) -> None:
    (entry,) = [entry for entry in springopt("list", "scenes") if entry["distribution"] != "springopt"]
    assert (entry["name"], entry["group"], entry["distribution"]) == ("worn-bridge", "bridges", "bridge-scenes")
    assert springopt("list", "scenes", "bridges") == [entry]


def test_a_run_on_one_finds_its_floor(springopt: Callable[..., Any]) -> None:
    run = springopt("solve", "worn-bridge", "--optimizer", "random-search", "--evaluations", "20")
    assert run["scene"] == "worn-bridge"
    assert (run["floor"]["value"], run["floor"]["proven"]) == (0.0, True)


def test_its_floor_is_computed_and_stored_where_the_package_lies(springopt: Callable[..., Any]) -> None:
    floor = springopt("floor", "worn-bridge")
    stored = Path(floor.pop("file"))
    assert stored.parts[-4:] == ("site-packages", "bridge_scenes", "floors", "worn-bridge.json")
    assert json.loads(stored.read_text(encoding="utf-8")) == floor
    shipped = json.loads((FOLDER / "bridge_scenes" / "floors" / "worn-bridge.json").read_text(encoding="utf-8"))
    assert (shipped["digest"], shipped["value"], shipped["proof"]) == (floor["digest"], 0.0, floor["proof"])
