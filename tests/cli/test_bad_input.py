"""Bad input ends in one sentence and exit code 2, with nothing written and no traceback."""

from pathlib import Path

import h5py
import pytest

from springopt.errors import PluginError

SOLVE = ("solve", "--optimizer", "random-search", "--evaluations", "5")


@pytest.mark.parametrize(
    ("command", "sentence"),
    [
        ("slove", "Did you mean 'solve'?"),
        ("solve nowhere", "there is no scene 'nowhere'."),
        ("solve paper-fem-3d", "Did you mean 'paper-fem-2d'?"),
        ("solve nowhere.toml", "scene nowhere.toml can't be read"),
        ("solve --optimizer random-serch", "Did you mean 'random-search'?"),
        ("solve --optimizer random-search --set batsch=3", "random-search has no option 'batsch'"),
        ("solve --optimizer random-search --set batch=3.5", "batch of random-search"),
        ("solve --optimizer random-search --set batch", "--set takes NAME=VALUE, not 'batch'"),
        ("solve --optimizer random-search --set =3", "--set takes NAME=VALUE, not '=3'"),
        ("solve --optimizer random-search --evaluations 0", "budget"),
        ("solve --optimizer random-search --evaluations 1.5", "not a valid integer"),
        ("solve --optimizer random-search --seconds nan", "budget"),
        ("solve --optimizer random-search --seed -1", "seed"),
        ("solve --optimizer random-search --out nowhere/run.h5", "nowhere"),
        ("solve --resume nowhere.h5", "nowhere.h5"),
        ("solve --resume nowhere.h5 --seed 3", "--resume goes on with the run as it was ordered; leave out --seed."),
        ("solve --no-such-option", "No such option"),
        ("simulate paper-fem-2d", "a scene states no stiffness of its own"),
        ("simulate paper-fem-2d --stiffness -1", "-1"),
        ("simulate paper-fem-2d --stiffness nan", "stiffness[0] is nan"),
        ("simulate paper-fem-2d --stiffness nowhere.npy", "nowhere.npy can't be read"),
        ("simulate paper-fem-2d --stiffness stiff.png", "a number or a .npy, .csv, .txt or .json file, not stiff.png"),
        ("simulate paper-fem-2d --stiffness 4 --figure a.jpg", "ends in .png or .pdf or .svg, not as a.jpg"),
        ("simulate paper-fem-2d --stiffness 4 --figure no/a.png", "the folder of no/a.png does not exist"),
        ("simulate nowhere.h5", "nowhere.h5"),
        ("identify nowhere", "there is no scene 'nowhere'."),
        ("identify nowhere.h5", "there is no run file nowhere.h5"),
        ("identify paper-fem-2d --at reference", "this scene's is none; leave out --at reference"),
        ("identify paper-fem-2d --at best", "a scene has none; give RUN.h5"),
        ("identify paper-fem-2d --noise 0", "noise is 0, but it must be positive"),
        ("identify paper-fem-2d --design 0", "0 is not in the range x>=1"),
        ("identify paper-fem-2d --design 5 --candidates test", "of 4 candidates 1 to 4 can be picked, not 5"),
        ("identify paper-fem-2d --design 1 --candidates nowhere", "there is no scene 'nowhere'"),
        ("identify paper-fem-2d --criterion A", "is not one of 'D', 'E'"),
        ("identify paper-fem-2d --figure a.jpg", "ends in .png or .pdf or .svg, not as a.jpg"),
        ("floor", "Missing argument 'SCENE'"),
        ("floor nowhere", "there is no scene 'nowhere'."),
        ("floor paper-fem-2d --starts 0", "0 is not in the range x>=1"),
        ("floor paper-fem-2d --from nowhere.h5", "there is no run file nowhere.h5"),
        ("show nowhere.h5", "nowhere.h5"),
        ("list optimisers", "is not one of 'optimizers', 'effects', 'scenes'"),
        ("list optimizers --floors", "--floors is of scenes, and optimizers have none; leave it out."),
        ("list scenes nowhere", "there is no scene and no group of scenes 'nowhere'; the groups are paper"),
        ("list optimizers nowhere", "nowhere"),
    ],
)
def test_a_mistake_is_answered_in_a_sentence(springopt, tmp_path: Path, command: str, sentence: str) -> None:
    code, out, err = springopt(*command.split())
    assert (code, out) == (2, "")
    assert sentence in err
    assert "Traceback" not in err
    assert not list(tmp_path.iterdir())


def test_all_faults_of_a_scene_are_said_at_once(springopt) -> None:
    Path("mine.toml").write_text('extends = "paper-fem-2d"\nreference = { young = -1 }\nbudget = { seconds = "1" }\n')
    code, _, err = springopt(*SOLVE, "mine.toml")
    assert code == 2
    assert "reference.young should be greater than 0, but is -1." in err
    assert "budget.seconds should be a valid number, but is '1'." in err


@pytest.mark.parametrize(
    "command",
    [
        (*SOLVE, "--out", "there.h5"),
        ("simulate", "paper-fem-2d", "--stiffness", "4", "--out", "there.npz"),
        ("simulate", "paper-fem-2d", "--stiffness", "4", "--figure", "there.png"),
    ],
)
def test_an_output_that_exists_is_never_overwritten(springopt, command: tuple[str, ...]) -> None:
    Path(command[-1]).write_text("precious")
    code, _, err = springopt(*command)
    assert code == 2
    assert f"{command[-1]} exists already, and nothing is overwritten" in err
    assert Path(command[-1]).read_text() == "precious"


def test_the_default_run_file_is_not_overwritten_either(springopt) -> None:
    assert springopt(*SOLVE).code == 0
    before = Path("paper-fem-2d-random-search-seed0.h5").read_bytes()
    code, _, err = springopt(*SOLVE)
    assert code == 2
    assert "--out" in err
    assert Path("paper-fem-2d-random-search-seed0.h5").read_bytes() == before


@pytest.mark.parametrize("command", [("show",), ("simulate",), ("solve", "--resume")])
@pytest.mark.parametrize("contents", ["text", "foreign"])
def test_a_file_that_is_no_run_is_refused(springopt, command: tuple[str, ...], contents: str) -> None:
    if contents == "text":
        Path("some.h5").write_text("no HDF5 at all")
    else:
        with h5py.File("some.h5", "w") as file:
            file["x"] = 1
    code, out, err = springopt(*command, "some.h5")
    assert (code, out) == (2, "")
    assert "some.h5" in err
    assert "Traceback" not in err


@pytest.mark.parametrize(
    "command", [("show",), ("solve", "--resume"), ("solve", "--optimizer", "random-search", "--out")]
)
def test_a_folder_is_no_run_file(springopt, command: tuple[str, ...]) -> None:
    for folder in (".", ""):
        code, out, err = springopt(*command, folder)
        assert (code, out) == (2, "")
        assert "folder" in err or "exists" in err


def test_a_run_that_was_killed_is_told_from_one_that_never_was(springopt) -> None:
    Path("killed.h5.journal").touch()
    code, _, err = springopt("show", "killed.h5")
    assert code == 2
    assert "there is no run file killed.h5" in err
    Path("killed.h5.journal").write_text("answers")
    code, _, err = springopt("show", "killed.h5")
    assert code == 2
    assert "finish it with springopt solve --resume killed.h5" in err


def test_our_own_fault_is_said_in_a_sentence_with_exit_code_1(springopt, monkeypatch: pytest.MonkeyPatch) -> None:
    from springopt import runner

    def broken(*_, **__):
        raise ZeroDivisionError("division by zero")

    monkeypatch.setattr(runner, "solve", broken)
    code, out, err = springopt(*SOLVE)
    assert (code, out) == (1, "")
    assert "springopt failed (ZeroDivisionError: division by zero), and that is its own fault" in err


def test_a_plugins_own_fault_names_the_plugin_and_what_to_do(springopt, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(self, problem, rng):
        problem.evaluate(problem.sample(rng, 3))
        raise ZeroDivisionError("division by zero")

    monkeypatch.setattr("springopt.random_search.RandomSearch.minimize", broken)
    code, out, err = springopt(*SOLVE, "--out", "a.h5")
    assert (code, out) == (2, "")
    assert "optimizer random-search (springopt.random_search) failed (ZeroDivisionError: division by zero)" in err
    assert "a.h5.journal" in err
    assert Path("a.h5.journal").exists()
    monkeypatch.setenv("SPRINGOPT_TRACEBACK", "1")
    with pytest.raises(PluginError):
        springopt(*SOLVE, "--out", "b.h5")


def test_too_little_memory_is_said_in_a_sentence(springopt, monkeypatch: pytest.MonkeyPatch) -> None:
    def greedy(self, problem, rng):
        raise MemoryError("Unable to allocate 7 PiB")

    monkeypatch.setattr("springopt.random_search.RandomSearch.minimize", greedy)
    code, out, err = springopt(*SOLVE)
    assert (code, out) == (2, "")
    assert "not enough memory for this (Unable to allocate 7 PiB)" in err
