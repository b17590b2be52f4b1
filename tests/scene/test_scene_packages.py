"""Scenes of other distributions: found by their entry point, and in nobody's way where they are broken."""

import sys
from collections.abc import Callable
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

from springopt.analysis.known_floor import floor_file
from springopt.errors import SceneError
from springopt.scene import SceneHead, bundled, bundled_scenes, load_scene

SMALL = 'extends = "paper-fem-2d-4"\ntitle = "Somebody\'s"\ngroup = "small"\n'
Install = Callable[..., Path]


@pytest.fixture
def install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Install:
    """Makes packages of scenes, as of distributions of the same names, and their entry points; gives their folder."""
    monkeypatch.syspath_prepend(tmp_path)

    def install(packages: dict[str, dict[str, str]]) -> Path:
        for package, scenes in packages.items():
            monkeypatch.delitem(sys.modules, package, raising=False)
            (tmp_path / package).mkdir()
            (tmp_path / package / "__init__.py").write_text("")
            for scene, text in scenes.items():
                (tmp_path / package / f"{scene}.toml").write_text(text)
        entries = [entry(package) for package in packages]
        monkeypatch.setattr(bundled, "entry_points", lambda group: entries)
        return tmp_path

    return install


def entry(package: str) -> EntryPoint:
    point = EntryPoint(name="scenes", value=package, group=bundled.GROUP)
    vars(point)["dist"] = type("Distribution", (), {"name": package.replace("_", "-")})()
    return point


def test_a_scene_of_a_package_is_listed_after_the_bundled_ones_and_loads_by_its_name(install: Install) -> None:
    folder = install({"small_scenes": {"mine": SMALL, "yours": 'extends = "mine.toml"\ntitle = "From a sibling"\n'}})
    heads = bundled_scenes()
    assert heads["mine"] == SceneHead("mine", "Somebody's", "small", "small-scenes")
    assert list(heads)[-2:] == ["mine", "yours"]
    assert [load_scene(name).group for name in ("mine", "yours")] == ["small", None]
    assert load_scene("yours").name == "yours"
    assert floor_file("mine") == folder / "small_scenes" / "floors" / "mine.json"


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("title = ", "TOMLDecodeError"),
        ('group = "small"', "scene.toml should have a title"),
        ('title = "Somebody\'s"\ngroup = 3', "its group should be a word"),
    ],
)
def test_a_broken_package_is_left_out_with_a_warning_that_names_its_distribution(
    install: Install, text: str, why: str
) -> None:
    install({"broken_scenes": {"scene": text, "other": SMALL}, "small_scenes": {"mine": SMALL}})
    with pytest.warns(RuntimeWarning, match=rf"scenes of broken-scenes can't be listed .*{why}") as warned:
        heads = bundled_scenes()
    assert len(warned) == 1
    assert "mine" in heads
    assert not {"scene", "other"} & set(heads)
    assert load_scene("mine").name == "mine"


def test_a_package_that_can_t_be_imported_is_left_out_likewise(install: Install) -> None:
    folder = install({"failing_scenes": {"scene": SMALL}, "small_scenes": {"mine": SMALL}})
    (folder / "failing_scenes" / "__init__.py").write_text("1 / 0")
    with pytest.warns(RuntimeWarning, match="scenes of failing-scenes can't be listed .ZeroDivisionError"):
        assert {"mine"} == set(bundled_scenes()) - bundled_names()
    with pytest.warns(RuntimeWarning, match="scenes of failing-scenes"):
        assert load_scene("mine").name == "mine"


def bundled_names() -> set[str]:
    folder = Path(bundled.__file__).parent / "scenes"
    return {path.stem for path in folder.glob("*.toml")}


def test_a_name_that_is_taken_stays_with_its_owner(install: Install) -> None:
    install({"a_scenes": {"mine": SMALL}, "b_scenes": {"mine": SMALL, "paper-fem-2d": SMALL}})
    with pytest.warns(RuntimeWarning) as warned:
        heads = bundled_scenes()
    assert [heads[name].distribution for name in ("mine", "paper-fem-2d")] == ["a-scenes", "springopt"]
    assert {str(warning.message) for warning in warned} == {
        "scene mine of b-scenes is left out, as a-scenes has one of that name; rename it.",
        "scene paper-fem-2d of b-scenes is left out, as springopt has one of that name; rename it.",
    }
    assert load_scene("paper-fem-2d").group == "paper"


def test_a_scene_of_no_package_is_refused_with_a_hint(install: Install) -> None:
    install({"small_scenes": {"mine": SMALL}})
    with pytest.raises(SceneError, match=r"there is no scene 'mines'\. Did you mean 'mine'\?"):
        load_scene("mines")
