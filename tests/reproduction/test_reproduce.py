"""From nothing to the page, in runs that are far too short."""

import re
from pathlib import Path

import pytest

from springopt.errors import PluginError, UserError
from springopt.reproduction import reproduce as module
from springopt.reproduction.experiments import EXPERIMENTS
from springopt.reproduction.extent import FULL, QUICK, Extent
from springopt.reproduction.reproduce import reproduce
from springopt.scene import load_scene

TINY = Extent("tiny", (100, 101), (100,), 0.0, least=10)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("reproduced")
    reproduce(place / "first", TINY, only=["topology-3d", "figure-1"], runs=place / "runs")
    return place


def test_a_page_has_its_sections_in_the_order_of_the_paper_each_with_the_command_that_repeats_it(folder: Path) -> None:
    text = (folder / "first" / "reproduction.md").read_text(encoding="utf-8")
    assert [line for line in text.splitlines() if line.startswith("## ")] == [
        "## Figure 1: how often to mutate",
        "## Section 3.2 and Figure 2: topology in 3D",
    ]
    for name in ("figure-1", "topology-3d"):
        assert f"\nspringopt reproduce --quick --only {name} --out {name}\n" in text
    assert "\nspringopt reproduce --quick --only topology-3d --only figure-1\n" in text
    assert "Springs found: 463 in the paper (section 3.2)" in text
    assert str(folder) not in text


def test_every_picture_that_a_page_shows_is_there(folder: Path) -> None:
    text = (folder / "first" / "reproduction.md").read_text(encoding="utf-8")
    pictures = re.findall(r"!\[[^]]*\]\(([^)]*)\)", text)
    assert pictures == ["reproduction/figure-1.png", "reproduction/figure-2.png"]
    assert all((folder / "first" / picture).stat().st_size > 10_000 for picture in pictures)


def test_runs_that_are_there_are_not_made_again(folder: Path) -> None:
    files = {path: path.stat().st_mtime_ns for path in (folder / "runs").rglob("*.h5")}
    assert len(files) == 5 * 2 + 3
    reproduce(folder / "second", TINY, only=["figure-1", "topology-3d"], runs=folder / "runs")
    assert {path: path.stat().st_mtime_ns for path in (folder / "runs").rglob("*.h5")} == files


def test_nothing_is_overwritten(folder: Path) -> None:
    with pytest.raises(UserError, match=r"reproduction\.md exists already, and nothing is overwritten"):
        reproduce(folder / "first", TINY)


def test_a_folder_that_can_t_be_made_is_one_sentence(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(UserError, match=r"the folder .*file/below can't be made .*; name another --out"):
        reproduce(tmp_path / "file" / "below", TINY, only=["figure-1"])


def test_what_an_interrupted_call_left_of_its_pictures_does_no_harm(tmp_path: Path, folder: Path) -> None:
    (tmp_path / "reproduction.partial").mkdir()
    reproduce(tmp_path, TINY, only=["figure-1"], runs=folder / "runs")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["reproduction", "reproduction.md"]


def test_an_experiment_that_there_is_not_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"there is no experiment 'figure1'.* Did you mean 'figure-1'"):
        reproduce(tmp_path, TINY, only=["figure1"])


def test_a_missing_plugin_is_one_sentence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "installed", lambda: ["random-search"])
    with pytest.raises(PluginError, match="needs the optimizers paper-ga, which are not installed; install springopt-"):
        reproduce(tmp_path, TINY, only=["figure-1"])


def test_names_differ_and_a_quick_run_is_shorter() -> None:
    assert len({experiment.name for experiment in EXPERIMENTS}) == len(EXPERIMENTS)
    scene = load_scene("paper-fem-2d")
    assert QUICK.evaluations(scene) < FULL.evaluations(scene) == 30_000
    assert QUICK.evaluations(load_scene("paper-fem-2d-two-class")) == 500


@pytest.mark.slow
def test_every_experiment_has_its_section_and_its_pictures_however_short_the_runs(tmp_path: Path) -> None:
    text = reproduce(tmp_path / "out", TINY).read_text(encoding="utf-8")
    assert [line[3:] for line in text.splitlines() if line.startswith("## ")] == [each.title for each in EXPERIMENTS]
    shown = {path.split("/")[1] for path in re.findall(r"!\[[^]]*\]\(([^)]*)\)", text)}
    assert shown == {path.name for path in (tmp_path / "out" / "reproduction").iterdir()}
    assert "nan" not in text.lower().split()
