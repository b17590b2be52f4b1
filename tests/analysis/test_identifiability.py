"""Which springs load cases identify, and how well: from cases that are known by hand to the bundled scenes."""

from pathlib import Path

import numpy as np
import pytest
from lines import line

from springopt.analysis import analytic_start
from springopt.analysis.floor import compute_floor
from springopt.analysis.identifiability import Identifiability, Shared, Unseen, identify
from springopt.analysis.point import Point, choose_point
from springopt.errors import UserError
from springopt.forward.status import Status
from springopt.optimizer import Optimizer
from springopt.problem import Problem
from springopt.scene import Setup, load_scene

EXAMPLES = Path(__file__).parents[2] / "examples"


def at_reference(setup: Setup, **options: float) -> Identifiability:
    return identify(setup, choose_point(setup, "reference"), **options)


def test_the_standard_error_of_one_spring_is_known_by_hand() -> None:
    found = at_reference(line([(0, 1)], [{"hold": [0], "push": {1: 0.4}}]), noise=1e-3)
    # u = f / k, so that noise of u is k^2 / f times as large in k.
    assert found.standard_errors == pytest.approx([1e-3 * 2.0**2 / 0.4], rel=1e-9)
    assert (found.rank, found.condition, found.unseen, found.shared) == (1, 1.0, [], [])


def test_load_cases_add_their_information() -> None:
    case = {"hold": [0], "push": {1: 0.4}}
    once, thrice = (at_reference(line([(0, 1)], [case] * count)) for count in (1, 3))
    assert once.standard_errors / thrice.standard_errors == pytest.approx([3**0.5])


def test_the_default_noise_is_a_thousandth_of_the_smallest_rest_length() -> None:
    setup = line([(0, 2), (2, 3)], [{"hold": [0], "push": {3: 0.4}}])
    assert at_reference(setup).noise == 1e-3


def test_parallel_springs_make_up_for_each_other_and_have_no_finite_error() -> None:
    found = at_reference(line([(0, 1), (0, 1), (1, 2)], [{"hold": [0], "push": {2: 0.4}}]))
    assert found.shared == [Shared(springs=[0, 1], free_directions=1)]
    assert np.isinf(found.standard_errors).tolist() == [True, True, False]
    assert (found.rank, found.unseen) == (2, [])


def test_a_spring_is_seen_where_only_one_of_its_ends_is_held() -> None:
    springs = [(0, 1), (1, 2), (2, 3)]
    turns = [{"hold": [0, 1], "push": {3: 0.4}}, {"hold": [2, 3], "push": {0: 0.4}}]
    assert at_reference(line(springs, turns[:1])).unseen == [Unseen(0, "both its ends are held in every load case")]
    assert at_reference(line(springs, turns)).unseen == []


@pytest.mark.parametrize(
    ("springs", "load_case", "spring", "why"),
    [
        ([(0, 1), (1, 2)], {"hold": [0], "push": {1: 0.3}}, 1, "its node 2 has no other spring and no load"),
        (
            [(0, 1), (1, 2), (2, 3)],
            {"hold": [0], "push": {1: 0.3}},
            1,
            "its part of the lattice moves as a rigid body",
        ),
        ([(0, 1), (0, 2), (2, 3)], {"hold": [0], "push": {1: 0.3}}, 1, "its part of the lattice stays at rest"),
        (
            [(0, 1), (1, 2), (2, 3)],
            {"hold": [0, 3], "push": {1: 0.3, 2: 0.3}},
            1,
            "it has its rest length at this stiffness, as by symmetry, and not at others",
        ),
    ],
)
def test_it_says_why_a_spring_is_not_seen(springs: list, load_case: dict, spring: int, why: str) -> None:
    found = at_reference(line(springs, [load_case]))
    assert {each.spring: each.why for each in found.unseen}[spring] == f"{why} in every load case"


def test_springs_that_are_held_in_their_direction_are_not_seen() -> None:
    upright = {"nodes": [[0.0, 0.0], [0.0, 1.0], [0.0, 3.0]], "springs": [[0, 1], [1, 2]]}
    lift = {"name": "lift", "hold": [{"on": [0, 2]}], "move": {"on": 1, "axes": ["y"], "by": [0.1]}}
    setup = line([(0, 1), (1, 2)], [lift], lattice=upright)
    found = at_reference(setup)
    assert [each.why for each in found.unseen] == ["its ends are held in its direction in every load case"] * 2
    assert (found.rank, found.condition) == (0, np.inf)


def test_ends_on_modes_that_nothing_resists_are_named() -> None:
    lattice = {
        "nodes": [[float(x), 0.0] for x in (0, 1, 5, 6, 8, 9)],
        "springs": [[0, 1], [2, 3], [4, 5], [3, 5]],
        "rest_lengths": [1.0, 1.0, 1.0, 1.0],
    }
    setup = line(
        [(0, 1), (2, 3), (4, 5), (3, 5)],
        [{"hold": [0], "push": {1: 0.3}}],
        stiffness=[2.0, 2.0, 2.0, 0.0],
        lattice=lattice,
    )
    reasons = {each.spring: each.why for each in at_reference(setup).unseen}
    assert reasons[3] == "its ends hang on modes that nothing resists in every load case"


def test_a_spring_is_seen_also_where_another_one_is_seen_far_better() -> None:
    loose = line([(0, 1), (0, 2)], [{"hold": [0], "push": {1: 0.4, 2: 1e-12}}], stiffness=[2.0, 1e-11])
    assert at_reference(loose).unseen == []


def test_of_sparse_lattices_what_is_unseen_moves_nothing_and_all_else_moves_something() -> None:
    setup = load_scene("paper-fem-2d-4").build()
    rng, cases = np.random.default_rng(0), [case for case in setup.cases if case.role == "train"]
    judged = 0
    while judged < 5:
        stiffness = np.where(rng.random(72) < 0.7, rng.uniform(2, 8, 72), 0.0)
        if set(setup.model.solve(stiffness, cases, 1e-12).status) != {Status.CONVERGED}:
            continue
        is_seen = identify(setup, Point(stiffness, "here")).is_seen
        present = np.flatnonzero(stiffness)
        changed = stiffness + 1e-3 * stiffness * np.eye(72)[present]
        positions = setup.model.solve_many(np.vstack([stiffness, changed]), cases, 1e-12).positions
        moved = np.abs(positions[1:] - positions[0]).max(axis=(1, 2, 3))
        np.testing.assert_array_equal(moved > 1e-9, is_seen[present])
        judged += 1


def test_different_causes_name_their_load_cases() -> None:
    cases = [{"name": "a", "hold": [0, 1], "push": {2: 0.4}}, {"name": "b", "hold": [0, 2], "push": {}}]
    (unseen,) = at_reference(line([(0, 1), (1, 2)], cases)).unseen
    assert unseen == Unseen(0, "both its ends are held in a; its part of the lattice stays at rest in b")


def test_with_one_side_held_the_springs_along_it_are_unseen() -> None:
    setup = load_scene(EXAMPLES / "one_side_held.toml").build()
    found = at_reference(setup)
    unseen = [each.spring for each in found.unseen]
    assert setup.lattice.nodes[setup.lattice.springs[unseen]][..., 0].tolist() == [[0.0, 0.0]] * 4
    assert {each.why for each in found.unseen} == {"both its ends are held in every load case"}
    assert found.rank == 68
    assert np.flatnonzero(np.isinf(found.standard_errors)).tolist() == unseen
    assert (found.best_case[unseen] == -1).all()


def test_with_one_face_held_42_of_468_springs_are_unseen() -> None:
    found = at_reference(load_scene(EXAMPLES / "one_face_held_3d.toml").build())
    assert {each.why for each in found.unseen} == {"both its ends are held in every load case"}
    assert (len(found.unseen), found.rank, found.shared) == (42, 426, [])


def test_too_few_equations_leave_no_spring_identified(tmp_path: Path) -> None:
    pull = '{ name = "pull", hold = "left", push = { on = "right", force = [0.3, 0.0] } }'
    (tmp_path / "pull.toml").write_text(
        f'extends = "paper-fem-2d"\ntitle = "One pull"\n[load_cases]\ntrain = [{pull}]\n'
    )
    setup = load_scene(tmp_path / "pull.toml").build()
    found = identify(setup, choose_point(setup))
    assert found.rank == 2 * 20
    assert np.isinf(found.standard_errors).all()
    assert sum(group.free_directions for group in found.shared) == 72 - 4 - 40


def test_errors_agree_with_differences_and_the_normal_equations() -> None:
    setup = load_scene("paper-fem-2d-4").build()
    found = identify(setup, choose_point(setup), noise=0.01)
    model, cases, h = setup.model, [case for case in setup.cases if case.role == "train"], 1e-4
    steps = found.stiffness + h * np.vstack([np.eye(72), -np.eye(72)])
    positions = model.solve_many(steps, cases, 1e-12).positions.reshape(2, 72, -1)
    jacobian = ((positions[0] - positions[1]) / (2 * h)).T
    expected = 0.01 * np.sqrt(np.diag(np.linalg.inv(jacobian.T @ jacobian)))
    np.testing.assert_allclose(found.standard_errors, expected, rtol=1e-6)


def test_springs_of_one_class_share_its_error_seen_or_not() -> None:
    scene = load_scene(EXAMPLES / "one_side_held.toml")
    encoding = load_scene("paper-fem-2d-two-class").encoding
    setup = scene.model_copy(update={"encoding": encoding}).build()
    found = at_reference(setup)
    assert (found.rank, len(found.singular_values), len(found.unseen)) == (2, 2, 4)
    for mask in setup.encoding.classes.values():
        assert len(set(found.standard_errors[mask].tolist())) == 1
    assert np.isfinite(found.standard_errors).all()


def test_bits_are_judged_by_the_stiffness_of_their_springs() -> None:
    setup = load_scene("paper-topology-2d-anisotropic").build()
    found = at_reference(setup)
    assert np.count_nonzero(found.stiffness == 0) == 16
    assert found.rank == 72
    assert np.isfinite(found.standard_errors).all()


def test_the_point_is_said() -> None:
    fem = load_scene("paper-fem-2d").build()
    assert choose_point(fem).said == "in the middle of the box, as no better point is known"
    assert choose_point(fem, best=np.ones(72)).said == "at the best point of the run"
    springs = load_scene("paper-stiffness-2d").build()
    assert choose_point(springs).said == "at the reference's stiffness"
    uneven = line([(0, 1), (1, 2)], [{"hold": [0]}], stiffness=[2.0, 4.0], encoding={"kind": "homogeneous", "upper": 9})
    assert choose_point(uneven).numbers.tolist() == [3.0]
    assert "closest to the reference's stiffness" in choose_point(uneven).said


def test_a_point_without_an_equilibrium_is_refused() -> None:
    setup = load_scene("paper-fem-2d").build()
    with pytest.raises(UserError, match="no derivatives at the best point of the run: Load case 'pull right'"):
        identify(setup, choose_point(setup, best=np.zeros(72)))


@pytest.mark.parametrize("is_installed", [True, False])
def test_the_analytic_start_is_that_of_the_plugin(monkeypatch: pytest.MonkeyPatch, is_installed: bool) -> None:
    class Formula(Optimizer):
        name = "analytic"

        def minimize(self, problem: Problem, rng: np.random.Generator) -> None:
            problem.evaluate(np.full((1, problem.size), 4.0))

    monkeypatch.setattr(analytic_start, "installed", lambda: ["analytic"] * is_installed)
    monkeypatch.setattr(analytic_start, "load_optimizer", lambda name: Formula)
    setup = load_scene("paper-fem-2d-two-class").build()
    if is_installed:
        assert choose_point(setup, "start").numbers.tolist() == [4.0, 4.0]
        assert compute_floor(setup, starts=1).analytic == pytest.approx(
            setup.objective.evaluate([[4.0] * 72]).values[0]
        )
    else:
        with pytest.raises(UserError, match="not installed or has no formula for this scene"):
            choose_point(setup, "start")


def test_a_spring_that_prestress_leaves_at_the_lattice_s_rest_length_is_seen() -> None:
    stretched = {"effects": [{"kind": "prestress", "scale": 0.5}]}
    found = at_reference(line([(0, 1), (1, 2)], [{"hold": (0, 2)}], **stretched))
    assert found.unseen == []
