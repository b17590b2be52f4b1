"""The scenes in the documentation are scenes."""

import re
from pathlib import Path

import pytest

from springopt.scene import load_scene
from springopt.scene.schema import Scene

PAGE = (Path(__file__).parents[2] / "docs" / "scenes.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("text", re.findall(r"```toml\n(.*?)```", PAGE, flags=re.DOTALL))
def test_a_documented_scene_builds(tmp_path: Path, text: str) -> None:
    (tmp_path / "documented.toml").write_text(text, encoding="utf-8")
    setup = load_scene(tmp_path / "documented.toml").build()
    assert setup.encoding.size == setup.lattice.spring_count + setup.encoding.parameter_count


def test_every_table_and_key_of_a_scene_is_documented() -> None:
    plain_keys = {"name", "title", "group", "kinematics", "engine", "branch"}
    headings = {"effects": "[[effects]]", "optimizers": "[optimizers."}
    tables = set(Scene.model_fields) - plain_keys
    assert not [name for name in tables if headings.get(name, f"[{name}]") not in PAGE]
    assert not [
        name for name in plain_keys - {"name"} if not re.search(rf"(^|`){name} = |`{name}`", PAGE, re.MULTILINE)
    ]
