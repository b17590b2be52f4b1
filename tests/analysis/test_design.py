"""Load cases to add: against brute force, and against the scene that has them."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from lines import line

from springopt.analysis.candidates import Candidate, candidates_of, generated
from springopt.analysis.design import design
from springopt.analysis.identifiability import identify
from springopt.analysis.point import choose_point
from springopt.errors import UserError
from springopt.load_case import LoadCase
from springopt.objective import Objective
from springopt.scene import Scene, Setup, load_scene

EXAMPLES = Path(__file__).parents[2] / "examples"
NOISE = 1e-3


@pytest.fixture(scope="module")
def one_side() -> Setup:
    return load_scene(EXAMPLES / "one_side_held.toml").build()


def with_cases(setup: Setup, cases: list[LoadCase]) -> np.ndarray:
    """The Jacobian in units of noise and box with these load cases beside the scene's, solved anew."""
    training = [case for case in setup.cases if case.role == "train"] + cases
    rest = np.stack([setup.lattice.nodes] * len(training))
    stiffness = setup.encoding.decode(choose_point(setup).numbers)
    jacobian = Objective(setup.model, training, rest, tolerance=1e-12).jacobian(stiffness)[1]
    return jacobian * (setup.encoding.upper - setup.encoding.lower) / np.sqrt(12) / NOISE


def log_det(rows: np.ndarray) -> float:
    return float(np.linalg.slogdet(np.eye(rows.shape[1]) + rows.T @ rows)[1])


def known(rows: np.ndarray) -> tuple[int, float]:
    """How many directions the data know better than the box, and the smallest eigenvalue of those."""
    eigenvalues = np.linalg.svd(rows, compute_uv=False) ** 2
    return int((eigenvalues > 1).sum()), float(eigenvalues[eigenvalues > 1].min())


@pytest.mark.parametrize("criterion", ["D", "E"])
def test_every_pick_is_the_best_by_brute_force(one_side: Setup, criterion: str) -> None:
    point = choose_point(one_side)
    candidates = generated(one_side, one_side.encoding.decode(point.numbers))[::4]
    picks = design(one_side, point, candidates, 2, criterion=criterion, noise=NOISE)
    cases: list[LoadCase] = []
    for pick in picks:
        before = log_det(with_cases(one_side, cases))
        left = [each for each in candidates if not any(each.case is case for case in cases)]
        rows = [with_cases(one_side, [*cases, candidate.case]) for candidate in left]
        gains = [log_det(each) - before for each in rows]
        assert [score.gain for score in pick.scores] == pytest.approx(gains, rel=1e-7)
        assert [score.known for score in pick.scores] == [known(each)[0] for each in rows]
        assert [score.smallest for score in pick.scores] == pytest.approx([known(each)[1] for each in rows], rel=1e-7)
        ranked = gains if criterion == "D" else [known(each) for each in rows]
        assert pick.candidate is left[ranked.index(max(ranked))]  # type: ignore[type-var]
        cases.append(pick.candidate.case)


def test_equal_candidates_are_picked_in_their_order() -> None:
    setup = line([(0, 1), (1, 2)], [{"hold": [0], "push": {1: 0.3}}])
    pull = LoadCase("pull", setup.cases[0].supports, np.array([[0, 0], [0, 0], [0.3, 0]]))
    candidates = [Candidate(replace(pull, name=name)) for name in "abc"]
    for criterion in "DE":
        picks = design(setup, choose_point(setup), candidates, 3, criterion=criterion, noise=NOISE)
        assert [pick.score.name for pick in picks] == ["a", "b", "c"]
        assert picks[0].score.gain > picks[1].score.gain > picks[2].score.gain


def test_the_load_case_that_sees_an_unseen_spring_is_picked_first() -> None:
    setup = line([(0, 1), (1, 2), (2, 3)], [{"hold": [0, 1], "push": {3: 0.3}}])
    held = setup.cases[0].supports
    others = held.copy()
    others[:2, 0], others[2:, 0] = False, True
    far = LoadCase("again", held, 3.0 * setup.cases[0].forces)
    turned = LoadCase("turned", others, np.array([[0.3, 0], [0, 0], [0, 0], [0, 0]]))
    for criterion in "DE":
        picks = design(
            setup, choose_point(setup), [Candidate(far), Candidate(turned)], 1, criterion=criterion, noise=0.01
        )
        assert picks[0].score.name == "turned"
        assert np.isfinite(picks[0].standard_errors).all()


def test_the_errors_with_a_pick_are_those_of_the_scene_that_has_it(one_side: Setup) -> None:
    point = choose_point(one_side)
    candidates = generated(one_side, one_side.encoding.decode(point.numbers))
    (pick,) = design(one_side, point, candidates, 1, noise=NOISE)
    tables = one_side.scene.load_cases.model_dump(exclude_none=True)
    tables["train"] = [*tables["train"], pick.candidate.table]
    data = one_side.scene.model_dump(exclude_none=True) | {"load_cases": tables}
    extended = Scene.model_validate(data).build()
    found = identify(extended, choose_point(extended), noise=NOISE)
    np.testing.assert_allclose(pick.standard_errors, found.standard_errors, rtol=1e-9)


def test_bits_and_classes_can_be_designed_for() -> None:
    for name in ("paper-topology-2d-isotropic", "paper-fem-2d-two-class"):
        setup = load_scene(name).build()
        (pick,) = design(setup, choose_point(setup), candidates_of(setup.scene, setup, test_alone=True), 1, noise=NOISE)
        assert pick.score.gain > 0
        assert pick.score.known == len(identify(setup, choose_point(setup)).singular_values)


def test_generated_load_cases_move_the_body_as_far_as_those_it_has(one_side: Setup) -> None:
    stiffness = one_side.encoding.decode(choose_point(one_side).numbers)
    candidates = generated(one_side, stiffness)
    assert len(candidates) == 4 * (3 + 2) * 2
    assert len({candidate.case.name for candidate in candidates}) == len(candidates)
    cases = [candidate.case for candidate in candidates]

    def furthest(cases: list[LoadCase]) -> np.ndarray:
        return np.linalg.norm(one_side.model.solve(stiffness, cases).displacements, axis=-1).max(axis=-1)

    reach = np.median(furthest(one_side.cases))
    assert furthest(cases) == pytest.approx(reach, rel=0.25)
    gentle = [replace(case, forces=1e-4 * case.forces) for case in cases]
    assert furthest(gentle) == pytest.approx(1e-4 * reach, rel=2e-3)


def test_sides_are_pulled_and_not_pushed(one_side: Setup) -> None:
    for candidate in generated(one_side, np.full(72, 5.0)):
        assert candidate.table is not None
        push = candidate.table["push"]
        on = {"left": (0, -1), "bottom": (1, -1), "right": (0, 1), "top": (1, 1)}.get(push["on"])
        if on is not None:
            axis, sign = on
            assert sign * push["total"][axis] >= 0


def test_a_load_case_without_an_equilibrium_is_not_generated() -> None:
    setup = line(
        [(0, 1), (2, 3)], [{"hold": [0, 3], "push": {1: 0.3}}]
    )  # two bodies: one floats where one side is held
    names = {candidate.case.name for candidate in generated(setup, np.full(2, 2.0))}
    assert not any(name.startswith(("hold left, load right", "hold right, load left")) for name in names)


def test_candidates_have_the_nodes_of_the_scene() -> None:
    setup = load_scene("paper-fem-2d").build()
    assert len(candidates_of(load_scene("paper-fem-2d-4"), setup, test_alone=False)) == 4 + 4
    with pytest.raises(UserError, match="are for other nodes than those of paper-fem-2d"):
        candidates_of(load_scene("paper-topology-3d"), setup, test_alone=False)
    held = load_scene(EXAMPLES / "one_side_held.toml").build()
    with pytest.raises(UserError, match="one_side_held has no test load cases to choose from"):
        candidates_of(held.scene, held, test_alone=True)


@pytest.mark.parametrize("count", [0, 3])
def test_only_what_is_there_can_be_picked(count: int) -> None:
    setup = line([(0, 1)], [{"hold": [0], "push": {1: 0.3}}])
    with pytest.raises(UserError, match=f"of 2 candidates 1 to 2 can be picked, not {count}"):
        design(setup, choose_point(setup), [Candidate(setup.cases[0])] * 2, count, noise=NOISE)


def test_a_body_that_nothing_moves_gives_no_size_of_loads() -> None:
    setup = line([(0, 1)], [{"hold": [0]}])
    with pytest.raises(UserError, match="the training load cases move nothing"):
        generated(setup, np.full(1, 2.0))
