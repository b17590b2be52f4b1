"""The bundled scenes: each builds, sees every spring, and holds the numbers that it or the paper states."""

import re

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from springopt.scene import Setup, bundled_scenes, load_scene
from springopt.scene.bundled import SCENE_GROUPS

#: Whose reference takes seconds to deform.
LARGE = {"scale-50000"}
#: Whose loads are large.
FAR = {"hard-column"}

every_scene = pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.slow if name in LARGE else ()) for name in bundled_scenes()]
)


def build(name: str) -> Setup:
    return load_scene(name).build()


def test_every_scene_has_a_group_and_the_groups_are_those_of_the_suite() -> None:
    groups = [head.group for head in bundled_scenes().values()]
    assert set(groups) == set(SCENE_GROUPS)
    assert groups == sorted(groups, key=lambda group: SCENE_GROUPS.index(str(group)))
    assert len(groups) >= 24


def test_there_is_a_scene_for_each_experiment_of_the_paper() -> None:
    topology = {"paper-topology-2d-isotropic", "paper-topology-2d-anisotropic", "paper-topology-3d"}
    limited = {f"paper-fem-2d-{limit}" for limit in ("4", "8", "homogeneous", "two-class", "three-class")}
    paper = {name for name, head in bundled_scenes().items() if head.group == "paper"}
    assert paper == topology | limited | {"paper-stiffness-2d", "paper-fem-2d"}


def test_the_scale_group_has_about_as_many_unknowns_as_its_names_say() -> None:
    for name in (name for name, head in bundled_scenes().items() if head.group == "scale"):
        scene = load_scene(name)
        count = scene.lattice.build().spring_count
        assert count == pytest.approx(int(name.removeprefix("scale-")), rel=0.07)
        assert scene.title.startswith(f"{count:,} unknowns")


def test_titles_say_how_many_springs_a_reference_has() -> None:
    for name in bundled_scenes():
        scene = load_scene(name)
        said = re.search(r"(\d+) of (\d+) springs", scene.title)
        if said:
            stiffness = scene.reference.spring_stiffness(scene.lattice.build())  # type: ignore[union-attr]
            assert (np.count_nonzero(stiffness), len(stiffness)) == (int(said[1]), int(said[2]))


@every_scene
def test_there_are_load_cases_to_judge_by(name: str) -> None:
    assert len(load_scene(name).load_cases.test) >= (1 if name in LARGE else 2)


@every_scene
def test_some_load_case_sees_every_spring(name: str) -> None:
    scene = load_scene(name)
    lattice = scene.lattice.build()
    seen = [
        case.free[lattice.springs].any(axis=(1, 2)) for case in scene.load_cases.build(lattice) if case.role == "train"
    ]
    assert np.any(seen, axis=0).all()


@every_scene
def test_the_reference_s_deformation_is_finite_and_moves_nodes(name: str) -> None:
    setup = build(name)
    furthest = np.linalg.norm(setup.reference_positions - setup.lattice.nodes, axis=2).max(axis=1)
    step = setup.objective.smallest_rest_length
    assert (furthest > 0.05 * step).all()
    assert (furthest < (4.0 if name in FAR else 0.75) * step).all()
    assert len(setup.cases) == len(setup.reference_positions)
    assert setup.objective.reference is not None
    judged = next(number for number, case in enumerate(setup.cases) if case.role == "test")  # never with noise
    again = setup.objective.reference.deform(setup.cases[judged])
    np.testing.assert_array_equal(again, setup.reference_positions[judged])


@every_scene
def test_the_middle_of_the_box_has_an_equilibrium(name: str) -> None:
    setup = build(name)
    middle = np.ones(setup.encoding.size) if setup.encoding.kind == "binary" else setup.encoding.upper / 2
    evaluation = setup.objective.evaluate(setup.encoding.decode(middle[None]))
    assert evaluation.values[0] < setup.objective.cost_cap


@every_scene
def test_budgets_are_whole_generations(name: str) -> None:
    scene = load_scene(name)
    default = 5 if scene.encoding.kind == "binary" else 10
    population = scene.optimizer_options("paper-ga").get("population", default)
    assert scene.budget.evaluations is not None
    assert scene.budget.evaluations % population == 0


def test_the_main_experiment_is_the_paper_s() -> None:
    setup = build("paper-fem-2d")
    roles = [case.role for case in setup.cases]
    assert (setup.lattice.spring_count, roles.count("train"), roles.count("test")) == (72, 12, 4)
    assert setup.scene.optimizer_options("paper-ga") == {"population": 10, "a": 5.0, "b": 0.0}
    training = setup.reference_positions[:12] - setup.lattice.nodes
    furthest = np.linalg.norm(training, axis=2).max(axis=1)
    assert ((furthest > 0.2) & (furthest < 0.6)).all()


def test_each_side_is_held_as_often_as_the_others() -> None:
    for name, times in {"paper-fem-2d": 3, "paper-fem-2d-8": 2, "paper-fem-2d-4": 1}.items():
        setup = build(name)
        held = [case.supports[:, 0].tobytes() for case in setup.cases if case.role == "train"]
        assert sorted(held.count(side) for side in set(held)) == [times] * 4


def test_the_best_homogeneous_stiffness_is_table_1_s() -> None:
    objective = build("paper-fem-2d-homogeneous").objective
    best = minimize_scalar(lambda k: objective.evaluate(np.full((1, 72), k)).values[0], bounds=(2, 7), method="bounded")
    assert best.x == pytest.approx(4.07, rel=0.05)
    assert best.x == pytest.approx(4.04, abs=0.01)


def test_the_anisotropic_reference_lacks_the_springs_of_one_diagonal() -> None:
    scene = load_scene("paper-topology-2d-anisotropic")
    stiffness = scene.reference.spring_stiffness(scene.lattice.build())  # type: ignore[union-attr]
    assert np.count_nonzero(stiffness) == 72 - 16


def test_the_3d_scene_is_the_paper_s() -> None:
    setup = build("paper-topology-3d")
    assert (setup.lattice.node_count, setup.lattice.spring_count, setup.encoding.size) == (64, 468, 468)
    assert [case.role for case in setup.cases].count("train") == 6
    assert setup.objective.evaluate(np.full((1, 468), 5.0)).values[0] == pytest.approx(0.0, abs=1e-9)
