"""Scenes from TOML: what they say, what they extend, and what they refuse."""

from pathlib import Path

import numpy as np
import pytest

from springopt.errors import SceneError
from springopt.lattice import SpringLattice
from springopt.load_case import LoadCase
from springopt.scene import Scene, load_scene
from springopt.scene.load import check, merge

SMALL = """
title = "A small scene"
lattice = { grid = [3, 2], spacing = 0.5 }
reference = { kind = "spring", stiffness = 5.0 }
encoding = { kind = "real", upper = 10.0 }
"""


def write(folder: Path, text: str, name: str = "mine.toml") -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def small_case(folder: Path, case: str) -> LoadCase:
    scene = load_scene(write(folder, SMALL + f"[load_cases]\ntrain = [{{ name = 'a', {case} }}]\n"))
    return scene.load_cases.build(scene.lattice.build())[0]


def refusal(folder: Path, text: str) -> str:
    with pytest.raises(SceneError) as caught:
        load_scene(write(folder, text))
    return str(caught.value)


def case_refusal(folder: Path, case: str) -> str:
    return refusal(folder, SMALL + f"[load_cases]\ntrain = [{{ name = 'a', {case} }}]\n")


def test_a_scene_survives_its_own_json() -> None:
    scene = load_scene("paper-fem-2d-two-class")
    assert Scene.from_json(scene.to_json()) == scene


def test_a_file_is_named_by_itself_and_its_defaults_are_filled_in(tmp_path: Path) -> None:
    scene = load_scene(write(tmp_path, SMALL + "[load_cases]\ntrain = [{ name = 'a', hold = 'left' }]\n"))
    assert (scene.name, scene.objective.minimize, scene.budget.evaluations) == ("mine", "distance", None)


def test_an_extending_scene_overrides_key_by_key(tmp_path: Path) -> None:
    path = write(tmp_path, 'extends = "paper-fem-2d"\ntitle = "Softer"\nreference = { young = 2.0 }\n')
    scene = load_scene(path)
    assert (scene.title, scene.reference.young, scene.reference.poisson) == ("Softer", 2.0, 0.3)  # type: ignore[union-attr]
    assert len(scene.load_cases.train) == 12


def test_a_path_to_extend_is_relative_to_the_scene_that_names_it(tmp_path: Path) -> None:
    (tmp_path / "deeper").mkdir()
    write(tmp_path, 'extends = "paper-fem-2d"\nbudget = { evaluations = 7 }\n', "base.toml")
    path = write(tmp_path / "deeper", 'extends = "../base.toml"\n', "mine.toml")
    assert load_scene(path).budget.evaluations == 7


def test_a_scene_that_extends_is_named_by_its_own_file_or_by_itself(tmp_path: Path) -> None:
    write(tmp_path, 'name = "base"\nextends = "paper-fem-2d"\n', "base.toml")
    assert load_scene(tmp_path / "base.toml").name == "base"
    assert load_scene(write(tmp_path, 'extends = "base.toml"\n')).name == "mine"
    assert load_scene(write(tmp_path, 'extends = "base.toml"\nname = "own"\n')).name == "own"


def test_a_table_of_another_kind_replaces_the_whole_table() -> None:
    assert merge({"e": {"kind": "real", "threshold": 0.5}}, {"e": {"kind": "homogeneous"}}) == {
        "e": {"kind": "homogeneous"}
    }
    assert merge({"lattice": {"grid": [5, 5], "radius": 2}}, {"lattice": {"mesh": "a.msh"}}) == {
        "lattice": {"mesh": "a.msh"}
    }


def test_scenes_that_extend_each_other_are_refused(tmp_path: Path) -> None:
    write(tmp_path, 'extends = "mine.toml"\n', "other.toml")
    assert "extends itself" in refusal(tmp_path, 'extends = "other.toml"\n')


def test_a_mesh_is_found_beside_the_scene_and_written_into_it(tmp_path: Path) -> None:
    import meshio

    lattice = SpringLattice.grid((3, 3), cell="triangle")
    points = np.column_stack([lattice.nodes, np.zeros(9)])
    meshio.Mesh(points, [("triangle", lattice.cells)]).write(tmp_path / "body.vtk")
    cases = 'load_cases = { train = [{ name = "a", hold = 4 }], test = [] }'
    text = f'extends = "paper-fem-2d"\nlattice = {{ mesh = "body.vtk" }}\n{cases}\n'
    scene = load_scene(write(tmp_path, text))
    (tmp_path / "body.vtk").unlink()
    again = Scene.from_json(scene.to_json()).lattice.build()
    assert np.array_equal(again.nodes, lattice.nodes)
    assert (again.spring_count, again.cell_type) == (16, "triangle")


def test_sides_and_node_numbers_are_held_together(tmp_path: Path) -> None:
    case = small_case(tmp_path, 'hold = ["left", 5]')
    assert np.flatnonzero(case.supports.all(axis=1)).tolist() == [0, 3, 5]


def test_single_axes_are_held(tmp_path: Path) -> None:
    case = small_case(tmp_path, 'hold = [{ on = "left", axes = "x" }, { on = 0, axes = ["y"] }]')
    assert case.supports[:, 0].tolist() == [True, False, False, True, False, False]
    assert case.supports[:, 1].tolist() == [True, False, False, False, False, False]


def test_forces_are_per_node_and_totals_are_spread(tmp_path: Path) -> None:
    case = small_case(
        tmp_path, 'hold = "left", push = [{ on = "right", total = [0, 3] }, { on = 5, force = [1.0, 0.0] }]'
    )
    assert case.forces[[2, 5]].tolist() == [[0.0, 1.5], [1.0, 1.5]]
    assert not case.forces[[0, 1, 3, 4]].any()


def test_a_force_on_a_held_node_is_legal(tmp_path: Path) -> None:
    assert small_case(tmp_path, 'hold = "left", push = { on = "left", force = [1.0, 0.0] }').forces.any()


def test_moves_prescribe_the_axes_in_the_order_named(tmp_path: Path) -> None:
    case = small_case(tmp_path, 'hold = "left", move = { on = 2, axes = ["y", "x"], by = [0.1, 0.2] }')
    assert case.prescribed[2].tolist() == [0.2, 0.1]
    assert case.supports[2].all()


def test_a_scale_multiplies_forces_and_moves_of_all_load_cases(tmp_path: Path) -> None:
    case = "name = 'a', hold = 'left', push = { on = 5, force = [1.0, 0.5] }, move = { on = 2, by = [0.1, 0.2] }"
    scene = load_scene(write(tmp_path, SMALL + f"[load_cases]\nscale = 3.0\ntrain = [{{ {case} }}]\n"))
    (built,) = scene.load_cases.build(scene.lattice.build())
    assert built.forces[5].tolist() == [3.0, 1.5]
    np.testing.assert_allclose(built.prescribed[2], [0.3, 0.6])
    assert built.supports[2].all()


def test_a_move_alone_supports_the_body(tmp_path: Path) -> None:
    assert small_case(tmp_path, 'move = { on = "left", by = [0.1, 0.0] }').supports[[0, 3]].all()


@pytest.mark.parametrize(
    ("case", "sentence"),
    [
        ("push = []", "load_cases.train[0]: load case 'a' has no supports"),
        ("hold = 'lfet'", "A side must be one of left, right, bottom, top, not 'lfet'. Did you mean 'left'?"),
        ("hold = 6", "load_cases.train[0].hold[0].on should name nodes 0 to 5, but names 6."),
        ("hold = -1", "should name nodes 0 to 5, but names -1."),
        ("hold = true", "should be a side, a node number or a list of these, but is True."),
        ("hold = { on = 'left', axes = ['z'] }", "should be a list of axes out of x, y, but is ['z']."),
        ("hold = 'left', push = { on = 'rigth', force = [1, 0] }", "push[0].on: A side must be one of"),
        ("hold = 'left', push = { on = 'right', force = [1, 0, 0] }", "one number for each of 2 axes"),
        ("hold = 'left', push = { on = 'right', force = [nan, 0] }", "force[0] should be a finite number, but is nan."),
        ("hold = 'left', push = { on = 'right', force = ['1', 0] }", "force[0] should be a valid number, but is '1'."),
        ("hold = 'left', push = { on = 'right' }", "should have one of force (on each node) and total"),
        ("hold = 'left', push = 3", "load_cases.train[0].push should be a valid list, but is 3."),
        ("hold = 'left', move = { on = 'right', by = [1] }", "one number for each of the axes x, y"),
        ("hold = 'left', move = { on = 'left', by = [1, 0] }", "prescribes x of node 0 twice, to 0 and 1; hold or"),
        ("move = [{ on = 2, by = [1, 0] }, { on = 'right', by = [2, 0] }]", "x of node 2 twice, to 1 and 2"),
    ],
)
def test_a_bad_load_case_is_refused_with_its_path(tmp_path: Path, case: str, sentence: str) -> None:
    assert sentence in case_refusal(tmp_path, case)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ("titel = 'x'", "titel is not a key of a scene; remove it. Did you mean 'title'?"),
        ("reference = { young = -1.0 }", "reference.young should be greater than 0, but is -1.0."),
        (
            "reference = { poisson = 0.6 }",
            "reference: Poisson's ratio must be above -1 and at most 0.5 in plane stress",
        ),
        ("reference = { poisson = 0.5, plane = 'strain' }", "below 0.5 in plane strain"),
        ("reference = { poisson = nan }", "reference.poisson should be a finite number, but is nan."),
        ("reference = { yuong = 1.0 }", "reference.yuong is not a key of a scene; remove it. Did you mean 'young'?"),
        (
            "reference = { kind = 'fme' }",
            "reference.kind should be one of fem, spring, random-springs, but is 'fme'. Did you mean 'fem'?",
        ),
        ("reference = { kind = 'spring' }", "reference.stiffness is missing; give it."),
        ("reference = { kind = 'spring', stiffness = -5 }", "stiffness is -5, but it must be finite and not negative."),
        ("reference = { kind = 'spring', stiffness = [1, 2] }", "one for each of 72 springs, not 2."),
        ("reference = { kind = 'spring', stiffness = '5' }", "should be a finite number or a list of such"),
        ("reference = { kind = 'spring', stiffness = 5, absent = [72] }", "absent names springs 0 to 71, not 72."),
        ("reference = { kind = 'spring', stiffness = 5, absent_directions = [[0, 0]] }", "not all zero"),
        ("reference = { kind = 'random-springs', seed = 0 }", "reference.stiffness is missing; give it."),
        (
            "reference = { kind = 'random-springs', seed = -1, stiffness = [1.0, 2.0] }",
            "reference.seed should be greater than or equal to 0, but is -1.",
        ),
        (
            "reference = { kind = 'random-springs', seed = 0, stiffness = [1.0, 2.0], kept = 0.5 }",
            "reference: kept leaves 36 of 72 springs, and with fewer than 47 the body is a mechanism",
        ),
        (
            "reference = { kind = 'random-springs', seed = 0, stiffness = [1.0, 2.0], kept = 1.5 }",
            "reference.kept should be less than or equal to 1, but is 1.5.",
        ),
        (
            "reference = { kind = 'random-springs', seed = 0, stiffness = [1.0, 2.0], anisotropy = [1.0] }",
            "reference: anisotropy must have the shape (2,), not (1,).",
        ),
        ("reference = { noise = { deviation = 0.0 } }", "reference.noise.deviation should be greater than 0"),
        ("reference = { noise = 0.1 }", "reference.noise should be a table"),
        ("reference = { noise = { sigma = 0.1 } }", "reference.noise.sigma is not a key of a scene"),
        ("reference = 3", "reference should be a table"),
        ("encoding = { kind = 'real', upper = -1.0 }", "encoding: the bounds of unknown 0 are [0, -1]"),
        ("encoding = { threshold = 10.0 }", "encoding: the threshold of the real encoding lies in [0, 10)"),
        ("encoding = { kind = 'binary', stiffness = 0 }", "must be positive and finite"),
        ("lattice = { grid = [5] }", "lattice.grid should have 2 or more entries, but has 1."),
        ("lattice = { grid = [5, 1] }", "lattice.grid[1] should be greater than or equal to 2, but is 1."),
        ("lattice = { grid = [5, 5.0] }", "lattice.grid[1] should be a valid integer, but is 5.0."),
        ("lattice = { neighbourhood = 'more' }", "but is 'more'. Did you mean 'moore'?"),
        ("lattice = { spacing = 0 }", "lattice: spacing is 0, but it must be positive and finite."),
        ("lattice = { mesh = 'none.msh' }", "does not exist"),
        ("lattice = { nodes = [[0, 0], [1, 0]], springs = [] }", "encoding: the real encoding needs springs"),
        ("lattice = { mesh = 'a.msh', nodes = [[0, 0]] }", "lattice should have one of grid, mesh and nodes."),
        ("objective = { minimize = 'mean' }", "objective.minimize should be 'distance', 'relative-distance' or"),
        ("budget = { evaluations = 0 }", "budget.evaluations should be greater than 0, but is 0."),
        ("budget = { evaluations = true }", "budget.evaluations should be a valid integer, but is True."),
        ("effects = [{ kind = 'gravity', acceleration = [0, 0, -9.81] }]", "effects[0]: acceleration must have"),
        ("optimizers = { paper-ga = 3 }", "optimizers.paper-ga should be"),
        ("stepping = { step = 0.1 }", "has [stepping], but its load cases have no times"),
        ("load_cases = { times = [1.0] }", "has load cases with times, but no [stepping]"),
        ("load_cases = { train = [] }", "load_cases.train should have 1 or more entries, but has 0."),
        (
            "load_cases = { test = [{ name = 'pull right', hold = 'left' }] }",
            "load_cases should give every load case a name of its own, but repeats 'pull right'.",
        ),
        ("extends = 3", "is not valid TOML"),
        ("= 3", "is not valid TOML"),
    ],
)
def test_a_bad_scene_is_refused_with_the_path_what_came_and_what_to_do(
    tmp_path: Path, change: str, sentence: str
) -> None:
    assert sentence in refusal(tmp_path, f'extends = "paper-fem-2d"\n{change}\n')


def test_all_faults_come_at_once(tmp_path: Path) -> None:
    text = 'extends = "paper-fem-2d"\nreference = { young = 0 }\nbudget = { seconds = -1 }\nencoding = { lower = 11 }\n'
    lines = refusal(tmp_path, text).splitlines()
    assert lines[0].endswith("mine.toml has 3 faults:")
    assert [line.split()[0] for line in lines[1:]] == ["reference.young", "encoding:", "budget.seconds"]


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        ("paper-fem-2", "there is no scene 'paper-fem-2'. Did you mean 'paper-fem-2d'?"),
        ("nowhere.toml", "scene nowhere.toml can't be read (No such file or directory)"),
        ("/", "can't be read"),
    ],
)
def test_a_scene_that_is_not_there_is_refused(name: str, sentence: str) -> None:
    with pytest.raises(SceneError) as caught:
        load_scene(name)
    assert sentence in str(caught.value)


def test_a_scene_that_is_no_text_is_refused(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_bytes(b"\xff\xfe")
    with pytest.raises(SceneError, match="not UTF-8 text"):
        load_scene(tmp_path / "mine.toml")


def test_noise_is_in_training_load_cases_alone_and_makes_another_scene(tmp_path: Path) -> None:
    clean = load_scene("paper-fem-2d-4")
    noise = "reference = { noise = { deviation = 0.001, seed = 1 } }"
    noisy = load_scene(write(tmp_path, f'extends = "paper-fem-2d-4"\n{noise}\n'))
    differences = noisy.build().reference_positions - clean.build().reference_positions
    roles = [case.role for case in noisy.build().cases]
    assert [bool(difference.any()) for difference in differences] == [role == "train" for role in roles]
    assert 0.0005 < differences[0].std() < 0.0015
    assert noisy.digest() != clean.digest()


def test_a_reference_that_floats_is_refused_with_its_load_case() -> None:
    scene = load_scene("paper-fem-2d")
    data = scene.model_dump(mode="python", exclude_none=True)
    data["load_cases"] = {"train": [{"name": "spin", "hold": 0, "push": {"on": 24, "force": [1.0, 0.0]}}]}
    with pytest.raises(SceneError, match="be deformed: Load case 'spin' leaves the body free to move in 1 rigid mode"):
        check(data, source="floating").build()


def test_a_reference_of_springs_without_an_equilibrium_says_how_it_ended(tmp_path: Path) -> None:
    case = "{ name = 'spin', hold = 0, push = { on = 5, force = [1.0, 0.0] } }"
    scene = load_scene(write(tmp_path, SMALL + f"kinematics = 'linear'\n[load_cases]\ntrain = [{case}]\n"))
    sentence = "an equilibrium in load case 'spin', but it ended as mechanism; add springs or change the load."
    with pytest.raises(SceneError, match=sentence):
        scene.build()


def test_a_scene_says_which_branch_its_model_is_on(tmp_path):
    cases = "[load_cases]\ntrain = [{ name = 'a', hold = 'left', push = { on = 'right', force = [0.1, 0.0] } }]\n"
    assert load_scene(write(tmp_path, SMALL + cases)).build().model.branch == "minimum"
    assert load_scene(write(tmp_path, 'branch = "followed"\n' + SMALL + cases)).build().model.branch == "followed"
    assert "branch" in refusal(tmp_path, 'branch = "folowed"\n' + SMALL + cases)
