"""The forward solve against answers of other codes: MuJoCo polished to 50 digits, and hand-made hard cases."""

import json
from pathlib import Path

import numpy as np
import pytest
from ladder import hard
from oracle import out_of_balance, smallest_eigenvalue

import springopt as so

DATA = Path(__file__).parents[1] / "data"
HARD = {case["id"]: case for case in json.loads((DATA / "hard" / "hard_cases.json").read_text())}
#: What each hard case must end as: as on the ladder, which leaves the rungs of contrast 1e16 open.
STATUS = {name: status for name, status in hard.STATUS.items() if status} | {"C03_grid3x3_1e16": "converged"}


def hard_case(entry):
    lattice = so.SpringLattice(
        entry["points"], np.array(entry["springs"], dtype=int), np.array(entry["L0"], dtype=float)
    )
    effects = [so.Gravity(entry["gravity"], entry["mass"])] if np.any(entry["gravity"]) else []
    return so.Model(lattice, effects), so.LoadCase("load", entry["fixed"], entry["load"]), np.array(entry["k"])


@pytest.mark.parametrize("name", STATUS)
def test_a_hard_case_ends_as_it_should(name):
    model, case, stiffness = hard_case(HARD[name]["input"])
    solution = model.solve(stiffness, [case])
    assert solution.status[0] == STATUS[name]
    expected = HARD[name]["expected"].get("value") or {}
    for key in ("x", "x_connected", "x_base"):
        if key in expected:
            known = np.array(expected[key])
            np.testing.assert_allclose(solution.positions[0][: len(known)], known, atol=1e-8)


def test_a_stiffness_ratio_beyond_double_precision_is_refused_not_answered_wrongly():
    model, case, stiffness = hard_case(HARD["C03_chain_1e-08_1e+08"]["input"])
    solution = model.solve(stiffness, [case])
    answer = np.array(HARD["C03_chain_1e-08_1e+08"]["expected"]["value"]["u"])
    assert solution.status[0] == "iteration limit" or np.allclose(solution.displacements[0], answer, rtol=1e-6)


@pytest.mark.parametrize("units", HARD["C05"]["input"]["unit_systems"], ids=lambda units: units["name"])
def test_every_unit_system_gives_the_same_answer(units):
    entry = dict(HARD["C05"]["input"])
    for key, factor in (("points", "length"), ("L0", "length"), ("k", "stiffness"), ("load", "force")):
        entry[key] = np.array(entry[key]) * units[f"{factor}_factor"]
    model, case, stiffness = hard_case(entry)
    solution = model.solve(stiffness, [case])
    assert solution.status[0] == "converged"
    known = np.array(HARD["C05"]["expected"]["value"]["x_base"]) * units["length_factor"]
    np.testing.assert_allclose(solution.positions[0], known, atol=1e-9 * 4 * units["length_factor"])


@pytest.mark.parametrize("name", ["grid5x5_random", "grid4x4x4_removed5"])
def test_equilibria_of_another_engine_are_found_again(name):
    data = np.load(DATA / "msm" / f"{name}.npz")
    lattice = so.SpringLattice(data["points"], data["springs"], data["L0"])
    unique = 0
    for number, load_name in enumerate(data["case_names"]):
        weight = data["mass"][:, None] * data["gravity"][number]
        case = so.LoadCase(str(load_name), data["fixed"], data["loads"][number])
        solution = so.Model(lattice, [so.Gravity(data["gravity"][number], data["mass"])]).solve(data["k"], [case])
        assert solution.status[0] == "converged"
        rest = out_of_balance(lattice, data["k"], solution.positions[0], case.forces + weight)
        assert np.abs(rest[case.free]).max() < 1e-8 * np.abs(case.forces + weight).max()
        assert smallest_eigenvalue(lattice, data["k"], solution.positions[0], case) > 0
        if np.abs(data["x"][number] - data["x_continuation"][number]).max() < 1e-9:
            np.testing.assert_allclose(solution.positions[0], data["x"][number], atol=1e-8)
            assert solution.energy[0] == pytest.approx(data["potential"][number], rel=1e-10)
            unique += 1
    assert unique >= 12


def test_candidates_near_a_known_model_deform_as_another_code_says():
    data = np.load(DATA.parents[1] / "benchmarks" / "data" / "P1.npz")
    lattice = so.SpringLattice(data["nodes"], data["springs"], data["rest_lengths"])
    cases = [
        so.LoadCase(str(name), data["fixed"], forces)
        for name, forces in zip(data["load_names"], data["loads"], strict=True)
    ]
    batch = so.Model(lattice).solve_many(data["candidates"][:16], cases)
    assert (batch.status == "converged").all()
    np.testing.assert_allclose(batch.positions[data["found"]], data["positions"][data["found"]], atol=1e-8)


@pytest.mark.parametrize("ratio", ["perfect", "imperfect"])
def test_the_column_through_its_critical_load(ratio):
    entry = HARD["C07"]["input"]
    model, held, stiffness = hard_case(entry)
    for known in HARD["C07"]["expected"]["value"][ratio]:
        forces = np.zeros(model.lattice.nodes.shape)
        forces[entry["tip_nodes"]] = [known.get("lateral_each", 0.0), -known["P"] / 2]
        case = so.LoadCase("press", held.supports, forces)
        solution = model.solve(stiffness, [case])
        assert solution.status[0] == "converged"
        assert smallest_eigenvalue(model.lattice, stiffness, solution.positions[0], case) > 0
        if ratio == "imperfect":
            np.testing.assert_allclose(solution.positions[0], known["x"], atol=1e-6)
        else:
            lowest = known.get("potential_buckled", known["potential_straight"])
            assert solution.energy[0] == pytest.approx(lowest, rel=1e-9)
