"""Every example runs, and one number of each is what it was."""

import importlib.util
from pathlib import Path
from types import ModuleType

import pytest

EXAMPLES = Path(__file__).parents[1] / "examples"


def example(name: str) -> ModuleType:
    specification = importlib.util.spec_from_file_location(name, EXAMPLES / f"{name}.py")
    assert specification is not None
    assert specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


def test_every_example_is_tested_here() -> None:
    assert {path.stem for path in EXAMPLES.glob("*.py")} == {"beam_with_scipy"}
    assert {path.parent.name for path in EXAMPLES.glob("*/pyproject.toml")} == {
        "third_party_effect",
        "third_party_optimizer",
        "third_party_scenes",
    }


def test_a_beam_is_learned_with_scipy(capsys: pytest.CaptureFixture[str]) -> None:
    _, found = example("beam_with_scipy").main()
    assert found.fun == pytest.approx(0.00846, rel=0.02)
    assert "inner straight" in capsys.readouterr().out
