"""Each command on a scene in motion that fits parameters of effects: it serves, or says in one sentence why not."""

import json
from pathlib import Path

import numpy as np
import pytest

from springopt.store import read

MOVING = str(Path(__file__).parents[1] / "data" / "nine-nodes-in-motion.toml")
STILL = """
extends = "paper-stiffness-2d"
title = "At rest, with a modulus to be found"
effects = [{ kind = "volume", modulus = 3.0 }]
[encoding]
lower = 0.5
parameters = [{ name = "volume.modulus", lower = 0.1, upper = 10.0 }]
"""
NAMES = ["damping.springs", "inertia.density"]


def solved(springopt, optimizer: str = "gauss-newton", *more: str) -> dict:
    code, out, err = springopt(
        "solve", MOVING, "--optimizer", optimizer, "--evaluations", "40", "--out", f"{optimizer}.h5", "--json", *more
    )
    assert (code, err) == (0, "")
    return json.loads(out)


def test_gauss_newton_finds_stiffness_damping_and_density_again(springopt) -> None:
    run = solved(springopt)
    assert run["objective"] < 1e-15
    assert run["parameters"]["damping.springs"] == pytest.approx([0.1], rel=1e-5)
    assert run["reference_parameters"] == {"damping.springs": [0.1], "inertia.density": [1.0]}
    assert run["parameter_intervals"] == {"damping.springs": [0.0, 0.5], "inertia.density": [0.5, 2.0]}
    file = read(Path("gauss-newton.h5"))
    assert file.positions.shape == file.reference_positions.shape == (3, 3, 9, 2)
    assert [case.times.tolist() for case in file.cases] == [[0.5, 1.0, 2.0]] * 3


@pytest.mark.parametrize(
    "optimizer", ["paper-ga", "annealing", "pymoo-ga", "nsga2", "l-bfgs-b", "dual-annealing", "random-search"]
)
def test_every_kind_of_optimizer_serves_it(springopt, optimizer) -> None:
    run = solved(springopt, optimizer)
    assert list(run["parameters"]) == NAMES
    assert len(run["stiffness"]) == 20
    assert len(run["point"]) == 22


@pytest.mark.parametrize(
    ("optimizer", "sentence"),
    [
        ("balance", "balance knows forces at rest, and these load cases have times"),
        ("analytic", "analytic tells Young's modulus from a body at rest"),
        ("sparse-path", "and this scene fits parameters of effects beside the springs"),
    ],
)
def test_who_knows_springs_at_rest_alone_says_so(springopt, optimizer, sentence) -> None:
    code, _, err = springopt("solve", MOVING, "--optimizer", optimizer, "--evaluations", "9")
    assert code == 2
    assert sentence in err


def test_show_has_a_table_of_parameters_and_draws_the_motion(springopt) -> None:
    solved(springopt)
    code, out, _ = springopt("show", "gauss-newton.h5", "--figure", "motion.png")
    assert code == 0
    _, _, table = out.partition("Parameters")
    assert "damping.springs" in table
    assert "20.0%" in table  # where in its interval
    assert Path("motion.png").read_bytes().startswith(b"\x89PNG")


def test_simulate_takes_what_the_run_found_and_writes_the_motion(springopt) -> None:
    solved(springopt, "random-search")
    code, out, _ = springopt("simulate", "random-search.h5", "--out", "motion.npz", "--figure", "motion.png")
    assert code == 0
    assert "at the last time" in out
    arrays, file = np.load("motion.npz"), read(Path("random-search.h5"))
    np.testing.assert_array_equal(arrays["positions"], file.positions)
    assert arrays["velocities"].shape == (3, 3, 9, 2)
    assert arrays["times"].tolist() == [[0.5, 1.0, 2.0]] * 3
    assert [arrays[name].tolist() for name in NAMES] == list(file.run.parameters.values())
    document = json.loads(springopt("simulate", "random-search.h5", "--json").out)
    assert document["parameters"] == file.run.parameters
    assert [len(document["load_cases"][0][name]) for name in ("times", "energy", "positions", "velocities")] == [3] * 4


def test_simulate_of_a_scene_takes_its_effects_as_they_are_stated(springopt) -> None:
    document = json.loads(springopt("simulate", MOVING, "--stiffness", "5", "--json").out)
    assert "parameters" not in document
    assert max(case["max_distance"] for case in document["load_cases"]) < 1e-8


def test_explain_says_how_it_moves_and_what_is_fitted(springopt) -> None:
    code, out, _ = springopt("explain", MOVING)
    assert code == 0
    assert "motion until 2, looked at 3 times: 8 steps of 0.25 at most, energy-momentum" in out
    assert "fitted beside the stiffness: damping.springs in [0, 0.5], inertia.density in [0.5, 2]" in out
    for text in ("Masses of the nodes", "A dissipation: its compiled kernel"):
        assert text in out


def test_a_floor_is_proven_where_the_reference_s_parameters_are_in_their_intervals(springopt) -> None:
    Path("moving.toml").write_text(f'extends = "{MOVING}"\ntitle = "Moving"\n')
    assert "floor 0 (least-squares), proven" in springopt("floor", "moving.toml").out
    Path("other.toml").write_text(
        f'extends = "{MOVING}"\ntitle = "Damped less"\n'
        '[encoding]\nparameters = [{ name = "damping.springs", lower = 0.2, upper = 0.5 }]\n'
    )
    document = json.loads(springopt("floor", "other.toml", "--starts", "2", "--json").out)
    assert document["proof"] is None
    assert document["point"][-1] == pytest.approx(0.2)  # as near as it may come


def test_identify_counts_parameters_among_the_unknowns_and_designs_motions(springopt) -> None:
    code, out, _ = springopt("identify", MOVING)
    assert code == 0
    assert "of 22 unknowns" in out
    assert "2 of 2 parameters" in out
    answer = json.loads(springopt("identify", MOVING, "--design", "1", "--json").out)
    assert [row["name"] for row in answer["parameters"]] == NAMES
    (pick,) = answer["design"]["picks"]
    errors = [row["standard_error"] for row in answer["parameters"]]
    assert all(after < before for after, before in zip(pick["parameter_errors"], errors, strict=True))


def test_balance_of_a_scene_at_rest_that_fits_parameters_is_refused_and_formulas_leave_them_in_the_middle(
    springopt,
) -> None:
    Path("still.toml").write_text(STILL)
    code, _, err = springopt("solve", "still.toml", "--optimizer", "balance", "--evaluations", "9")
    assert code == 2
    assert "volume adds forces of its own" in err
    run = json.loads(springopt("solve", "still.toml", "--optimizer", "analytic", "--out", "a.h5", "--json").out)
    assert run["parameters"] == {"volume.modulus": [5.05]}


def test_a_benchmark_of_it_says_who_can_not_serve_and_is_compared(springopt) -> None:
    names = "random-search,gauss-newton,balance"
    code, out, _ = springopt(
        "benchmark", "--scenes", MOVING, "--optimizers", names, "--seeds", "2", "--evaluations", "20", "--out", "b"
    )
    assert code == 0
    assert "motion" in out
    code, out, _ = springopt("compare", "b")
    assert code == 0
    assert "gauss-newton" in out


def test_explain_measures_what_each_effect_costs(springopt):
    block = str(Path(__file__).parents[2] / "examples" / "soft_block_on_plane.toml")
    code, out, err = springopt("explain", block, "--measure", "--seconds", "0", "--json")
    assert (code, err) == (0, "")
    answer = json.loads(out)
    assert answer["measured"]["rounds"] >= 7
    plane = next(effect for effect in answer["effects"] if effect["name"] == "plane")
    assert plane["kernels"] == ["add_plane"]
    assert plane["acts_on_reference"]
    code, out, _ = springopt("explain", block, "--measure", "--seconds", "0")
    assert code == 0
    assert "bending changes positions by 0.04%" in out
