"""Tables of effects: read off the effect's own fields, whoever wrote it."""

import subprocess
import sys
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

from springopt import registry
from springopt.effects.gravity import Gravity
from springopt.errors import SceneError
from springopt.scene import Scene, load_scene

STRANGE = '''
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from springopt.effects.effect import Effect


@dataclass(frozen=True)
class Strange(Effect):
    """Has an option of every type."""

    name = "strange"
    count: int  #: how many
    weights: Mapping[str, float] | None = None  #: by name
    side: Literal["left", "right"] = "left"  #: which
    is_on: bool = True  #: whether
'''


@pytest.fixture
def strange(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """An effect of another distribution, beside gravity and one that can't be imported."""
    (tmp_path / "strange_effect.py").write_text(STRANGE, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    values = {
        "gravity": "springopt.effects.gravity:Gravity",
        "strange": "strange_effect:Strange",
        "gone": "springopt_gone:Gone",
    }
    entries = [EntryPoint(name, value, registry.EFFECT_GROUP) for name, value in values.items()]
    monkeypatch.setattr(registry, "entry_points", lambda group: entries)
    monkeypatch.delitem(sys.modules, "strange_effect", raising=False)


def scene(folder: Path, *effects: str) -> Scene:
    path = folder / "mine.toml"
    text = f'extends = "paper-fem-2d"\ntitle = "Mine"\neffects = [{", ".join(effects)}]\n'
    path.write_text(text, encoding="utf-8")
    return load_scene(path)


def test_an_effect_is_built_of_its_options_and_again_of_the_scene_s_json(tmp_path: Path) -> None:
    stated = scene(tmp_path, "{ kind = 'gravity', acceleration = [0, -9.81], mass = 2 }")
    assert Scene.from_json(stated.to_json()) == stated
    assert stated.effects[0].build() == Gravity((0.0, -9.81), mass=2.0)


def test_a_stated_default_is_no_other_scene(tmp_path: Path, strange: None) -> None:
    digests = {scene(tmp_path, f"{{ kind = 'strange', count = 1{more} }}").digest() for more in ("", ", is_on = true")}
    assert len(digests) == 1
    assert scene(tmp_path, "{ kind = 'strange', count = 2 }").digest() not in digests
    assert scene(tmp_path).digest() == load_scene("paper-fem-2d").digest()


@pytest.mark.parametrize(
    ("table", "sentences"),
    [
        ("{ kind = 'gravty' }", ["effects[0].kind should be one of gone, gravity, strange, but is 'gravty'. Did you"]),
        ("{ acceleration = [0, 1] }", ["scene", "effects[0].kind is missing; give it."]),
        ("{ kind = 'gone' }", ["effects[0].kind: effect gone of an unknown distribution can't be loaded (ModuleNot"]),
        ("{ kind = 'strange', cont = 1 }", ["effects[0].cont is not an option of strange; remove it. Did you mean 'c"]),
        ("{ kind = 'strange' }", ["effects[0].count is missing; give it."]),
        ("{ kind = 'strange', count = '1' }", ["effects[0].count should be a whole number, but is '1'."]),
        (
            "{ kind = 'strange', count = 1, is_on = 'true' }",
            ["effects[0].is_on should be true or false, but is"],
        ),
        (
            "{ kind = 'strange', count = 1, side = 'top' }",
            ["effects[0].side should be 'left' or 'right', but"],
        ),
        (
            "{ kind = 'strange', count = 1, weights = { a = 'b' } }",
            ["should be a table, each a number or none, but"],
        ),
        ("{ kind = 'gravity', acceleration = [0, 1, 2] }", ["effects[0]: acceleration must have the shape (2,), not"]),
        ("{ kind = 'gravity', acceleration = [0, nan] }", ["effects[0].acceleration should be a list, each a number"]),
        ("{ kind = 'strange', count = 1.0, site = 2 }", ["2 faults", "effects[0].count", "effects[0].site"]),
    ],
)
def test_a_bad_table_is_refused_with_its_path(tmp_path: Path, strange: None, table: str, sentences: list[str]) -> None:
    with pytest.raises(SceneError) as caught:
        scene(tmp_path, table)
    assert all(sentence in str(caught.value) for sentence in sentences)


def test_only_what_a_scene_names_is_imported(tmp_path: Path, strange: None) -> None:
    scene(tmp_path, "{ kind = 'gravity', acceleration = [0, 1] }")
    assert "strange_effect" not in sys.modules
    scene(tmp_path, "{ kind = 'strange', count = 1 }")
    assert "strange_effect" in sys.modules


def test_a_scene_without_effects_imports_none() -> None:
    script = "import sys, springopt; springopt.load_scene('paper-stiffness-2d'); print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert not [name for name in done.stdout.split() if name.startswith("springopt.effects")]
