"""Each command, from its words to what it prints and writes."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from springopt.cli.list import _as_set
from springopt.scene.bundled import SCENE_GROUPS

SOLVE = ("solve", "--optimizer", "random-search", "--evaluations", "40")


def test_solve_prints_errors_classes_and_the_run_file(springopt) -> None:
    code, out, _ = springopt(*SOLVE)
    assert code == 0
    assert "paper-fem-2d, random-search, seed 0: objective" in out
    for text in ("pull right", "press between", "The sums over train are the objective", "boundary straight"):
        assert text in out
    assert "springopt show paper-fem-2d-random-search-seed0.h5 --figure" in out
    assert Path("paper-fem-2d-random-search-seed0.h5").is_file()
    assert not Path("paper-fem-2d-random-search-seed0.h5.journal").exists()


def test_solve_as_json_is_one_document_with_what_machines_need(springopt) -> None:
    code, out, err = springopt(*SOLVE, "--seed", "3", "--out", "mine.h5", "--json")
    run = json.loads(out)
    assert (code, err) == (0, "")
    assert {"processor_seconds", "seconds", "solves"} < set(run)
    assert (run["evaluations"], run["optimizer"], run["scene"]) == (40, "random-search", "paper-fem-2d")
    assert (run["seed"], run["run"], len(run["stiffness"])) == (3, "mine.h5", 72)
    training = [error["distance"] for error in run["errors"] if error["role"] == "train"]
    assert run["objective"] == pytest.approx(sum(training))


def test_what_an_optimizer_prints_is_kept_out_of_the_document(springopt, monkeypatch: pytest.MonkeyPatch) -> None:
    def chatty(self, problem, rng):
        print("here I am")
        problem.evaluate(problem.sample(rng, 3))

    monkeypatch.setattr("springopt.random_search.RandomSearch.minimize", chatty)
    code, out, err = springopt(*SOLVE, "--json")
    assert (code, err) == (0, "here I am\n")
    assert json.loads(out)["evaluations"] == 3


def test_the_same_seed_gives_the_same_answer_and_another_seed_another(springopt) -> None:
    answers = [
        json.loads(springopt(*SOLVE, "--seed", seed, "--out", f"{i}.h5", "--json").out)["objective"]
        for i, seed in enumerate("001")
    ]
    assert answers[0] == answers[1] != answers[2]


def test_solve_takes_a_scene_of_one_s_own_and_options(springopt) -> None:
    text = 'extends = "paper-fem-2d-two-class"\ntitle = "Mine"\n[optimizers.random-search]\nbatch = 4\n'
    Path("mine.toml").write_text(text)
    run = json.loads(springopt(*SOLVE, "mine.toml", "--json").out)
    assert (run["scene"], run["options"], list(run["classes"])) == ("mine", {"batch": 4}, ["straight", "diagonal"])
    run = json.loads(springopt(*SOLVE, "mine.toml", "--set", "batch=5", "--out", "five.h5", "--json").out)
    assert run["options"] == {"batch": 5}


def test_a_run_begins_at_the_best_point_of_another_and_says_so(springopt) -> None:
    first = json.loads(springopt(*SOLVE, "--out", "first.h5", "--json").out)
    code, out, _ = springopt(*SOLVE, "--start", "first.h5")
    assert code == 0
    assert "paper-fem-2d, random-search from first.h5, seed 0: objective" in out
    run = json.loads(springopt("show", "paper-fem-2d-random-search-from-first-seed0.h5", "--json").out)
    assert (run["start"], run["history"][0]["evaluations"]) == ("first.h5", 1)
    assert run["history"][0]["value"] == first["objective"]


def test_a_complete_run_is_only_read_when_it_is_resumed(springopt) -> None:
    first = json.loads(springopt(*SOLVE, "--out", "mine.h5", "--json").out)
    code, out, _ = springopt("solve", "--resume", "mine.h5", "--json")
    assert (code, json.loads(out)) == (0, first)


def test_an_interrupted_run_says_how_to_go_on_and_exits_130(springopt, monkeypatch: pytest.MonkeyPatch) -> None:
    from springopt import runner

    solve = runner.solve

    def interrupted(*arguments, **options):
        return replace(solve(*arguments, **options), complete=False, why_stopped="interrupted")

    monkeypatch.setattr(runner, "solve", interrupted)
    code, _, err = springopt(*SOLVE, "--out", "mine.h5")
    assert code == 130
    assert "springopt solve --resume mine.h5" in err


def test_show_prints_what_solve_printed_and_draws_a_figure(springopt) -> None:
    solved = springopt(*SOLVE, "--out", "mine.h5").out
    code, out, _ = springopt("show", "mine.h5", "--figure", "mine.png")
    assert code == 0
    assert out.partition("Run file")[0] == solved.partition("Run file")[0]
    assert Path("mine.png").read_bytes().startswith(b"\x89PNG")
    assert set(json.loads(springopt("show", "mine.h5", "--json").out)) >= {"objective", "errors", "history"}


def test_a_front_is_shown_as_a_table_and_drawn(springopt, monkeypatch: pytest.MonkeyPatch) -> None:
    def two_goals(self, problem, rng):
        problem.objectives(problem.sample(rng, 40))

    monkeypatch.setattr("springopt.random_search.RandomSearch.minimize", two_goals)
    run = json.loads(springopt(*SOLVE, "--out", "mine.h5", "--json").out)
    springs, values = run["front"]["springs"], run["front"]["values"]
    assert (springs, values) == (sorted(set(springs)), sorted(set(values), reverse=True))
    assert values[-1] == run["objective"]
    _, out, _ = springopt("show", "mine.h5", "--figure", "mine.png")
    _, _, table = out.partition("Front")
    assert f"{springs[0]} {springs[0] / 72:.1%} {values[0]:.4g}" in " ".join(table.split())


def test_simulate_tells_of_every_load_case_and_writes_arrays(springopt) -> None:
    code, out, _ = springopt(
        "simulate", "paper-fem-2d", "--stiffness", "4.2", "--out", "here.npz", "--figure", "here.svg"
    )
    assert code == 0
    assert out.count("converged") == 16
    with np.load("here.npz") as arrays:
        assert arrays["positions"].shape == arrays["reference_positions"].shape == (16, 25, 2)
        assert set(arrays["status"]) == {"converged"}
    assert Path("here.svg").is_file()


def test_simulate_of_a_run_repeats_its_errors(springopt) -> None:
    run = json.loads(springopt(*SOLVE, "--out", "mine.h5", "--json").out)
    cases = json.loads(springopt("simulate", "mine.h5", "--json").out)["load_cases"]
    assert [case["distance"] for case in cases] == [error["distance"] for error in run["errors"]]
    assert np.array(cases[0]["positions"]).shape == (25, 2)


SMALL = """
title = "Small"
effects = [{ kind = "gravity", acceleration = [0.0, -0.1] }, { kind = "inertia", mass = 1.0 }]
lattice = { grid = [3, 3], neighbourhood = "moore" }
reference = { kind = "spring", stiffness = 1.0 }
encoding = { kind = "real", upper = 2.0, parameters = [{ name = "gravity.mass", lower = 0.1, upper = 5.0 }] }
load_cases.train = [{ name = "a", hold = "left", push = { on = "right", total = [0.3, 0.0] } }]
"""
MOTION = SMALL + "load_cases.times = [0.2, 0.5]\nstepping = { step = 0.1 }\n"


@pytest.mark.parametrize("text", [SMALL, MOTION], ids=["at rest", "in motion"])
def test_a_run_with_fitted_parameters_is_shown_simulated_and_drawn_with_them(springopt, text: str) -> None:
    Path("mine.toml").write_text(text)
    solve = ("solve", "mine.toml", *SOLVE[1:], "--out", "mine.h5")
    run = json.loads(springopt(*solve, "--json").out)
    cases = json.loads(springopt("simulate", "mine.h5", "--json").out)["load_cases"]
    assert [case["distance"] for case in cases] == [error["distance"] for error in run["errors"]]
    assert len(json.loads(springopt("simulate", "mine.h5", "--json").out)["stiffness"]) == 20
    assert springopt("simulate", "mine.h5", "--figure", "here.svg").code == 0
    code, out, _ = springopt("show", "mine.h5", "--figure", "there.svg")
    assert (code, "gravity.mass" in out, f"{run['parameters']['gravity.mass'][0]:.6g}" in out) == (0, True, True)


@pytest.mark.parametrize("command", ["floor", "identify"])
def test_bounds_that_an_effect_would_refuse_are_refused(springopt, command: str) -> None:
    Path("mine.toml").write_text(SMALL.replace("lower = 0.1", "lower = -0.1"))
    code, _, err = springopt(command, "mine.toml")
    assert (code, "the bounds of gravity.mass are [-0.1, 5], but gravity.mass is -0.1" in err) == (2, True)


def test_the_floor_of_a_scene_with_parameters_is_at_the_reference(springopt) -> None:
    Path("mine.toml").write_text(SMALL)
    assert "floor 0 (distance), proven" in springopt("floor", "mine.toml").out


@pytest.mark.parametrize("ending", ["npy", "csv", "txt", "json"])
def test_stiffness_is_read_from_a_file(springopt, ending: str) -> None:
    stiffness = np.linspace(1.0, 8.0, 72)
    path = Path(f"stiffness.{ending}")
    if ending == "npy":
        np.save(path, stiffness)
    elif ending == "json":
        path.write_text(json.dumps({"stiffness": stiffness.tolist()}))
    else:
        np.savetxt(path, stiffness[None], delimiter="," if ending == "csv" else " ")
    answer = json.loads(springopt("simulate", "paper-fem-2d-4", "--stiffness", str(path), "--json").out)
    assert answer["stiffness"] == pytest.approx(stiffness.tolist())


def test_a_candidate_without_springs_is_an_answer_and_no_error(springopt) -> None:
    code, out, _ = springopt("simulate", "paper-fem-2d", "--stiffness", "0")
    assert code == 0
    assert out.count("mechanism") == 16


def test_list_scenes_shows_titles_and_one_scene_s_text(springopt) -> None:
    assert "Stiffness and topology from a 2D finite element reference" in springopt("list", "scenes").out
    assert 'extends = "paper-fem-2d"' in springopt("list", "scenes", "paper-fem-2d-4").out
    paper = json.loads(springopt("list", "scenes", "paper", "--json").out)
    assert len(paper) == 10
    assert paper[0] == {
        "name": "paper-fem-2d",
        "title": "Stiffness and topology from a 2D finite element reference, 12 load cases (section 4.3)",
        "group": "paper",
        "distribution": "springopt",
    }
    everything = json.loads(springopt("list", "scenes", "--json").out)
    assert everything[:10] == paper


def test_list_scenes_tells_floors(springopt) -> None:
    out = springopt("list", "scenes", "paper", "--floors").out
    rows = {words[0]: words[1:] for words in map(str.split, out.splitlines()) if words}
    assert rows["paper-fem-2d"][:3] == ["72", "0.1252", "0.106224089"]
    assert rows["paper-fem-2d"][3:] == ["best", "known;", "20", "of", "20", "starts", "ended", "there"]
    assert rows["paper-topology-3d"] == ["468", "3.084", "0", "proven"]
    entry = json.loads(springopt("list", "scenes", "paper", "--floors", "--json").out)[0]
    assert (entry["name"], entry["unknowns"], entry["proven"]) == ("paper-fem-2d", 72, False)
    assert entry["evidence"]["agreed"] == 20


def test_list_scenes_names_each_group_once(springopt) -> None:
    lines = [line.split() for line in springopt("list", "scenes").out.splitlines()]
    groups = [words[0] for words in lines if len(words) > 1 and words[0] in SCENE_GROUPS]
    assert groups == sorted(set(groups), key=SCENE_GROUPS.index)
    assert groups[0] == "paper"


def test_list_optimizers_names_distributions_and_one_optimizer_s_options(springopt) -> None:
    out = springopt("list", "optimizers").out
    assert "random-search" in out
    assert "Uniform sampling of the box." in out
    assert "candidates per call" in springopt("list", "optimizers", "random-search").out
    entry = next(e for e in json.loads(springopt("list", "optimizers", "--json").out) if e["name"] == "random-search")
    assert (entry["distribution"], entry["options"][0]["default"]) == ("springopt", 32)


def test_list_effects_names_what_they_bring_and_one_effect_s_options(springopt) -> None:
    out = springopt("list", "effects").out
    assert "constant forces, a potential" in out
    assert "The weight of the nodes" in out
    out = springopt("list", "effects", "gravity").out
    assert "required" in out
    assert "[length / time^2]" in out
    entry = json.loads(springopt("list", "effects", "gravity", "--json").out)
    assert [option["name"] for option in entry["options"]] == ["acceleration", "mass", "density"]
    assert springopt("list", "effects", "gravty").err.endswith("Did you mean 'gravity'?\n")
    assert "effects have none" in springopt("list", "effects", "--floors").err


def test_explain_names_engine_effects_and_reasons(springopt) -> None:
    code, out, err = springopt("explain", "paper-topology-3d")
    assert (code, err) == (0, "")
    for text in ("468 springs", "144 unknowns", "lanes", "stretch x, shear x along y", "Effects"):
        assert text in out


def test_explain_as_json_is_one_document(springopt) -> None:
    code, out, err = springopt("explain", "paper-fem-2d", "--json")
    explanation = json.loads(out)
    assert (code, err) == (0, "")
    assert explanation["supports"][0]["engine"] == "lanes"
    assert explanation["effects"][0]["name"] == "springs"


ONE_SIDE = str(Path(__file__).parents[2] / "examples" / "one_side_held.toml")


def test_identify_names_unseen_springs_and_the_worst_and_best(springopt) -> None:
    code, out, err = springopt("identify", ONE_SIDE, "--figure", "one.png")
    assert (code, err) == (0, "")
    for text in (
        "at the reference's stiffness",
        "rank 68 of 72 unknowns",
        "noise of the reference's coordinates 0.001",
    ):
        assert text in out
    assert "4  both its ends are held in every load case  1 (0 - 5), 18 (5 - 10), 35 (10 - 15), 52 (15 - 20)" in out
    assert "Identified springs, worst and best" in out
    assert Path("one.png").read_bytes().startswith(b"\x89PNG")


def test_identify_as_json_is_one_document(springopt) -> None:
    answer = json.loads(springopt("identify", ONE_SIDE, "--noise", "0.01", "--json").out)
    assert (answer["rank"], answer["unknowns"], answer["noise"], len(answer["unseen"])) == (68, 72, 0.01, 4)
    assert answer["springs"][1] == {
        "spring": 1,
        "nodes": [0, 5],
        "stiffness": 5.0,
        "standard_error": None,
        "seen_best_in": None,
    }
    assert answer["springs"][0]["seen_best_in"] in ("pull right", "shear right", "drag top")


def test_identify_of_a_run_looks_at_its_best_point(springopt) -> None:
    springopt(*SOLVE, "--out", "mine.h5")
    answer = json.loads(springopt("identify", "mine.h5", "--json").out)
    run = json.loads(springopt("show", "mine.h5", "--json").out)
    assert answer["at"] == "at the best point of the run"
    assert [row["stiffness"] for row in answer["springs"]] == run["point"]


def test_identify_designs_load_cases_that_a_scene_can_take_over(springopt) -> None:
    code, out, err = springopt("identify", ONE_SIDE, "--design", "2")
    assert (code, err) == (0, "")
    assert "Load cases that help most, D-optimal" in out
    lines = out.partition("As a scene states them:\n")[2]
    Path("more.toml").write_text(
        f'extends = "{ONE_SIDE}"\ntitle = "More"\n[load_cases]\ntrain = [\n{lines}]\n', encoding="utf-8"
    )
    more = json.loads(springopt("identify", "more.toml", "--at", "reference", "--json").out)
    assert more["rank"] > 40


def test_identify_s_design_as_json_has_every_candidate_s_score(springopt) -> None:
    arguments = ("--design", "2", "--criterion", "E", "--candidates", "test", "--json")
    answer = json.loads(springopt("identify", "paper-fem-2d-4", *arguments).out)["design"]
    assert (answer["criterion"], answer["candidates"], len(answer["picks"])) == ("E", "test", 2)
    first, second = answer["picks"]
    assert (len(first["scores"]), len(second["scores"])) == (4, 3)
    assert first["name"] in [score["name"] for score in first["scores"]]
    assert (first["known"], first["identified"], first["table"]) == (72, 72, None)
    assert second["smallest"] > first["smallest"]
    scores = springopt("identify", "paper-fem-2d-4", "--design", "1", "--candidates", "paper-fem-2d", "--json").out
    assert len(json.loads(scores)["design"]["picks"][0]["scores"]) == 12 + 4


def test_identify_says_when_too_little_is_known(springopt) -> None:
    lines = Path(ONE_SIDE).read_text().splitlines()
    Path("pull.toml").write_text("\n".join(line for line in lines if "shear" not in line and "drag" not in line))
    code, out, _ = springopt("identify", "pull.toml")
    assert code == 0
    assert "0 of 72 springs identified" in out
    assert "68 springs make up for each other in 28 independent ways, so that none of them is identified" in out
    assert "worst and best" not in out


def test_explain_of_no_scene_is_a_mistake_in_one_sentence(springopt) -> None:
    code, _, err = springopt("explain", "paper-fem-3d")
    assert code == 2
    assert "there is no scene 'paper-fem-3d'" in err


@pytest.mark.parametrize(("default", "text"), [(None, "none"), (False, "false"), ((1, 2), "1,2"), (0.5, "0.5")])
def test_a_default_is_listed_as_set_takes_it(default, text) -> None:
    assert _as_set(default) == text
