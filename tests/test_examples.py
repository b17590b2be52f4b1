"""Every example runs, and one number of each is what it was."""

import importlib.util
from pathlib import Path
from types import ModuleType

import pytest

from springopt.run import Run
from springopt.runner import solve

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
    assert {path.stem for path in EXAMPLES.glob("*.toml")} == {
        "one_side_held",  # with identify
        "one_face_held_3d",
        "step_response",
        "recovered_tissue",
        "pressed_block",
        "soft_block_on_plane",  # with explain --measure
    }
    assert {path.parent.name for path in EXAMPLES.glob("*/pyproject.toml")} == {
        "third_party_effect",
        "third_party_optimizer",
        "third_party_scenes",
    }


def solved(name: str) -> Run:
    """By one search of gauss-newton, which is enough for each of them."""
    return solve(EXAMPLES / f"{name}.toml", "gauss-newton", options={"starts": 1})


def test_damping_is_found_from_a_step_response() -> None:
    run = solved("step_response")
    assert run.objective == pytest.approx(0.002306, rel=1e-3)
    assert run.parameters["damping.springs"] == pytest.approx([0.1042], rel=1e-3)


def test_tissue_is_found_again_with_its_law_and_its_modulus() -> None:
    run = solved("recovered_tissue")
    assert run.objective < 1e-9
    assert run.parameters["volume.modulus"] == pytest.approx([3.0], rel=1e-6)
    assert run.parameters["exponential.exponent"] == pytest.approx([4.0], rel=1e-6)


def test_a_block_is_pressed_by_a_ball() -> None:
    run = solved("pressed_block")
    assert run.objective == pytest.approx(0.02248, rel=1e-3)


def test_a_beam_is_learned_with_scipy(capsys: pytest.CaptureFixture[str]) -> None:
    _, found = example("beam_with_scipy").main()
    assert found.fun == pytest.approx(0.00846, rel=0.02)
    assert "inner straight" in capsys.readouterr().out
