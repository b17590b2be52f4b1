import importlib.util
import os
import shutil
import subprocess
import sys
from importlib.machinery import SourceFileLoader
from pathlib import Path

import pytest

RUN = Path(__file__).parents[1] / "run"


@pytest.fixture
def run(tmp_path, monkeypatch):
    """The script as a module that looks at a small project of its own."""
    loader = SourceFileLoader("run", str(RUN))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader("run", loader))
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    loader.exec_module(module)
    for name, value in {"ROOT": ".", "VENV": ".venv", "PYTHON": ".venv/bin/python", "STAMP": ".venv/stamp"}.items():
        monkeypatch.setattr(module, name, str(tmp_path / value))
    (tmp_path / "plugins" / "one").mkdir(parents=True)
    (tmp_path / ".venv" / "bin").mkdir(parents=True)
    (tmp_path / ".venv" / "bin" / "python").symlink_to(sys.executable)
    for path in ("pyproject.toml", "plugins/one/pyproject.toml", "constraints.txt"):
        (tmp_path / path).write_text("")
    (tmp_path / ".venv" / "stamp").write_text(module.fingerprint())
    return module


def test_without_arguments_it_explains_itself():
    done = subprocess.run([sys.executable, str(RUN)], capture_output=True, text=True)
    assert done.returncode == 0
    assert "./run pytest" in done.stdout


def test_a_stamped_environment_is_fresh(run):
    assert run.is_fresh()


@pytest.mark.parametrize("path", ["pyproject.toml", "plugins/one/pyproject.toml", "constraints.txt"])
def test_a_changed_project_file_makes_it_stale(run, tmp_path, path):
    (tmp_path / path).write_text("changed")
    assert not run.is_fresh()


def test_a_new_plugin_makes_it_stale(run, tmp_path):
    (tmp_path / "plugins" / "two").mkdir()
    assert run.is_fresh()
    (tmp_path / "plugins" / "two" / "pyproject.toml").write_text("")
    assert not run.is_fresh()


def test_an_unfinished_environment_is_not_taken_for_done(run, tmp_path):
    (tmp_path / ".venv" / "stamp").unlink()
    assert not run.is_fresh()


def test_an_environment_whose_python_is_gone_is_stale(run, tmp_path):
    python = tmp_path / ".venv" / "bin" / "python"
    python.unlink()
    python.symlink_to(tmp_path / "gone")
    assert not run.is_fresh()


def test_an_environment_of_another_python_is_stale(run, tmp_path):
    python = tmp_path / ".venv" / "bin" / "python"
    python.unlink()
    python.symlink_to(RUN)
    assert not run.is_fresh()


def test_core_and_plugins_are_installed_in_one_command(run, tmp_path, monkeypatch):
    commands = []
    monkeypatch.setattr(run, "call", commands.append)
    run.install(["pip", "install"])
    (command,) = commands
    projects = [command[place + 1] for place, word in enumerate(command) if word == "--editable"]
    assert projects == [f"{tmp_path}[dev]", f"{tmp_path}/plugins/one"]


def test_an_unfinished_installation_leaves_no_stamp(run, tmp_path, monkeypatch, capsys):
    def fails(command):
        raise subprocess.CalledProcessError(1, command)

    monkeypatch.setattr(run, "call", fails)
    (tmp_path / "constraints.txt").write_text("changed")
    assert run.main(["pytest"]) == 1
    assert not (tmp_path / ".venv" / "stamp").exists()
    assert "could not be made" in capsys.readouterr().err


@pytest.mark.slow
def test_a_bare_checkout_makes_its_environment_once(tmp_path):
    root = RUN.parent
    for name in ("run", "pyproject.toml", "constraints.txt", "LICENSE", "README.md"):
        if (root / name).exists():
            shutil.copy(root / name, tmp_path)
    for name in ("springopt", "plugins"):
        shutil.copytree(root / name, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__"))
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    command = [tmp_path / "run", "python", "-c", "import springopt; print(springopt.__file__)"]
    # Without the path that pytest's worker processes hand on, which leads here.
    bare = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    first, second = (subprocess.run(command, cwd=elsewhere, capture_output=True, text=True, env=bare) for _ in range(2))
    assert first.stdout == second.stdout == f"{tmp_path}/springopt/__init__.py\n"
    assert "making .venv" in first.stderr
    assert not second.stderr
