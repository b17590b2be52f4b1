"""`springopt compare`, as people call it."""

import json
import shutil
from pathlib import Path

import pytest

from springopt.random_search import RandomSearch
from springopt.runner import solve

SCENES = ("paper-fem-2d-4", "paper-fem-2d-two-class")


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two sizes of batches on two scenes, and an optimizer that serves neither."""
    folder = tmp_path_factory.mktemp("study")
    for scene in SCENES:
        for label, batch in {"wide": 16, "narrow": 2}.items():
            (folder / scene / label).mkdir(parents=True)
            for seed in range(3):
                out = folder / scene / label / f"seed{seed}.h5"
                solve(scene, RandomSearch(batch=batch), seed=seed, evaluations=32, out=out)
        refused = folder / scene / "stubborn" / "refused.json"
        refused.parent.mkdir()
        refused.write_text('{"word": "binary", "sentence": "stubborn needs bits; choose another optimizer."}')
    return folder


def test_it_prints_gaps_running_times_ranks_and_overhead(springopt, results: Path) -> None:
    done = springopt("compare", str(results))
    assert done.code == 0
    for title in ("Median gap to the floor", "Expected running time to 1e-2", "Ranks over 2 scenes", "overhead"):
        assert title in done.out
    (line,) = [line for line in done.out.splitlines() if line.startswith(" stubborn") or line.startswith("stubborn")]
    assert line.split() == ["stubborn", "binary", "binary"]
    assert "Without stubborn: not on paper-fem-2d-4, paper-fem-2d-two-class (binary)." in " ".join(done.out.split())


def test_one_scene_is_shown_in_full(springopt, results: Path) -> None:
    done = springopt("compare", str(results), "--scene", SCENES[0], "--target", "1")
    assert done.code == 0
    assert f"{SCENES[0]}: expected running time to 1e-1 of the way" in done.out
    assert f"{SCENES[0]}: which runs end lower" in done.out
    assert "Not served: stubborn needs bits" in done.out
    assert SCENES[1] not in done.out


def test_runs_that_failed_are_counted_where_rates_are_printed(springopt, results: Path, tmp_path: Path) -> None:
    copy = shutil.copytree(results, tmp_path / "copy")
    for seed in (1, 2):
        (copy / SCENES[0] / "wide" / f"seed{seed}.h5").rename(copy / f"{seed}")
        (copy / SCENES[0] / "wide" / f"seed{seed}.failed.json").write_text('{"sentence": "it divided by zero."}')
    assert "of 3 (2 failed)" in springopt("compare", str(copy), "--scene", SCENES[0]).out
    over_scenes = springopt("compare", str(copy)).out
    assert over_scenes.count("(2 failed)") == 2
    assert f"runs failed (2 of wide on {SCENES[0]})" in over_scenes


def test_an_optimizer_is_chosen_by_the_name_that_is_shown(springopt, results: Path, tmp_path: Path) -> None:
    copy = shutil.copytree(results, tmp_path / "copy")
    out = copy / SCENES[0] / "wide" / "seed7.h5"
    solve(SCENES[0], RandomSearch(batch=4), seed=7, evaluations=16, out=out)
    name = "wide (batch=16, budget of evaluations=32)"
    document = json.loads(springopt("compare", str(copy), "--optimizers", f"narrow,{name}", "--json").out)
    assert {each["method"] for each in document["methods"]} == {"narrow", name}


def test_names_come_with_commas_or_repeated(springopt, results: Path) -> None:
    for arguments in (["--optimizers", "wide,narrow"], ["--optimizers", "wide", "--optimizers", "narrow"]):
        document = json.loads(springopt("compare", str(results), *arguments, "--json").out)
        assert {each["method"] for each in document["methods"]} == {"wide", "narrow"}
        assert not document["refusals"]


def test_figures_and_a_table_are_written_beside_what_is_printed(springopt, results: Path, tmp_path: Path) -> None:
    done = springopt("compare", str(results), "--csv", "all.csv", "--figures", "drawn", "--json")
    assert done.code == 0
    assert json.loads(done.out)["target"] == 2
    drawn = {path.name for path in (tmp_path / "drawn").iterdir()}
    assert {"critical-difference.png", "running-times.png", f"convergence-{SCENES[0]}.png"} <= drawn
    assert (tmp_path / "all.csv").read_text().startswith("scene,method,other,quantity,target,unit,value,low,high,word")


def test_nothing_is_overwritten(springopt, results: Path, tmp_path: Path) -> None:
    (tmp_path / "all.csv").touch()
    (tmp_path / "drawn").mkdir()
    (tmp_path / "drawn" / "mine.png").touch()
    for arguments in (["--csv", "all.csv"], ["--figures", "drawn"], ["--figures", "all.csv"]):
        done = springopt("compare", str(results), *arguments)
        assert done.code == 2
        assert "nothing is overwritten" in done.err
    assert springopt("compare", str(results), "--csv", "all.txt").code == 2


@pytest.mark.parametrize("folder", ["/dev/null/x", "/proc/x"])
def test_a_folder_that_can_t_be_made_is_told_before_anything_is_read(springopt, folder: str) -> None:
    done = springopt("compare", "nowhere", "--figures", folder)
    assert done.code == 2
    assert f"{folder} can't be made" in done.err


def test_where_nothing_can_be_compared_no_folder_is_left(springopt, tmp_path: Path) -> None:
    assert springopt("compare", "nowhere", "--figures", "deep/drawn").code == 2
    assert not (tmp_path / "deep").exists()


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--scenes", ""], "--scenes names nothing"),
        (["--optimizers", ","], "--optimizers names nothing"),
        (["--scene", ""], "--scene is empty"),
        (["--scene", SCENES[0], "--scenes", SCENES[1]], "give one of the two"),
    ],
)
def test_a_choice_that_says_nothing_is_refused(springopt, results: Path, arguments: list[str], sentence: str) -> None:
    done = springopt("compare", str(results), *arguments)
    assert done.code == 2
    assert sentence in done.err


def test_a_mistake_is_one_sentence(springopt, results: Path) -> None:
    done = springopt("compare", str(results), "--scenes", "paper-fem")
    assert done.code == 2
    assert "these results have no scene 'paper-fem'" in done.err
    assert springopt("compare", "nowhere").code == 2
    assert springopt("compare").code == 2
