"""A stranger's package is built from its folder, installed beside the project, and found by its entry point alone."""

import json
import os
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

FOLDER = Path(__file__).parents[1] / "examples" / "third_party_optimizer"
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


def test_it_is_listed_with_its_distribution_and_its_options(springopt: Callable[..., Any]) -> None:
    entry = next(entry for entry in springopt("list", "optimizers") if entry["name"] == "compass-search")
    assert entry["distribution"] == "compass-search"
    assert [option["name"] for option in entry["options"]] == ["first", "last"]


def test_it_keeps_the_contract(springopt: Callable[..., Any]) -> None:
    assert springopt("check-plugin", "compass-search")["passed"]


def test_it_solves_a_scene(springopt: Callable[..., Any]) -> None:
    order = ("--optimizer", "compass-search", "--set", "first=0.2", "--evaluations", "300")
    run = springopt("solve", "paper-fem-2d-two-class", *order)
    assert (run["optimizer"], run["options"]["first"], run["evaluations"]) == ("compass-search", 0.2, 300)
    assert run["objective"] < 0.2
