"""The floor of a scene: from values that are known by hand to the stored ones of the bundled scenes."""

import json
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from lines import line

from springopt.analysis import floor_search
from springopt.analysis.analytic_start import analytic_start
from springopt.analysis.descent import gradient_optimum
from springopt.analysis.floor import compute_floor, floor_at
from springopt.analysis.known_floor import Floor, floor_file, read_floor, store_floor, stored_floors
from springopt.analysis.point import reference_row
from springopt.budget import Budget
from springopt.errors import UserError
from springopt.problem import Problem
from springopt.scene import Scene, bundled_scenes, load_scene

PULLS = [{"hold": [0], "push": {1: 0.4, 2: 0.4, 3: 0.4}}]
STAR = [(0, 1), (0, 2), (0, 3)]  # three springs side by side, each with a load of its own


def test_a_reference_in_the_encodings_set_makes_the_floor_zero_and_proven() -> None:
    floor = compute_floor(line([(0, 1)], [{"hold": [0], "push": {1: 0.4}}], stiffness=3.0))
    assert (floor.value, floor.point, floor.scene, floor.minimize) == (0.0, None, "line", "distance")
    assert floor.proof == "the reference is in the encoding's set, and no misfit is negative"
    assert floor.reached == pytest.approx(0.0, abs=1e-9)


def test_noise_leaves_no_proof() -> None:
    spring = {"kind": "spring", "stiffness": 3.0, "noise": {"deviation": 1e-9}}
    data = line([(0, 1)], [{"hold": [0], "push": {1: 0.4}}]).scene.model_dump(exclude_none=True) | {"reference": spring}
    floor = compute_floor(Scene.from_json(json.dumps(data)).build(), starts=2)
    assert floor.proof is None
    assert floor.point == pytest.approx([3.0], rel=1e-6)


def test_a_reference_outside_the_box_leaves_the_distance_at_the_bound() -> None:
    floor = compute_floor(line([(0, 1)], [{"hold": [0], "push": {1: 0.4}}], stiffness=20.0), starts=3)
    assert floor.point == [10.0]
    assert floor.value == pytest.approx((0.4 / 10 - 0.4 / 20) / 2)  # the mean over two nodes
    assert (floor.proof, floor.evidence["agreed"], floor.evidence["starts"]) == (None, 3, 3)


@pytest.mark.parametrize(
    ("minimize", "stiffness"), [("distance", 4.0), ("relative-distance", 4.0), ("least-squares", 72 / 17)]
)
def test_one_stiffness_for_three_springs_is_the_median_or_the_mean_of_their_flexibility(
    minimize: str, stiffness: float
) -> None:
    setup = line(
        STAR,
        PULLS,
        stiffness=[3.0, 4.0, 8.0],
        encoding={"kind": "homogeneous", "lower": 1.0, "upper": 10.0},
        objective={"minimize": minimize},
    )
    floor = compute_floor(setup, starts=4)
    assert floor.point == pytest.approx([stiffness], rel=1e-7)
    assert floor.value == pytest.approx(setup.objective.evaluate(np.full((1, 3), floor.point[0])).values[0])
    assert floor.evidence["agreed"] == 4


def test_of_bits_the_floor_is_that_of_all_of_them() -> None:
    springs = [(0, 1), (1, 2), (2, 3), (0, 2), (1, 3), (0, 3), (0, 1)]
    setup = line(
        springs,
        [{"hold": [0], "push": {3: 0.4, 1: -0.2}}, {"hold": [3], "push": {1: 0.3}}],
        stiffness=[1.0, 4.0, 1.5, 0.4, 3.5, 0.0, 2.0],
        encoding={"kind": "binary", "stiffness": 3.0},
    )
    floor = compute_floor(setup, starts=5)
    points = np.array(list(product((0.0, 1.0), repeat=len(springs))))
    values = setup.objective.evaluate(setup.encoding.decode(points)).values
    assert floor.value == values.min()
    assert floor.proof is None
    assert floor.evidence["starts"] == 6


def test_the_same_seed_gives_the_same_floor() -> None:
    setup = load_scene("paper-fem-2d-two-class").build()
    assert compute_floor(setup, starts=2) == compute_floor(setup, starts=2)


def test_a_floor_needs_a_start() -> None:
    with pytest.raises(UserError, match="at least 1 start, not 0"):
        compute_floor(line([(0, 1)], [{"hold": [0]}]), starts=0)


def a_floor(value: float, **facts: object) -> Floor:
    given = {"scene": "s", "digest": "d", "minimize": "distance", "proof": None, "reached": value, "point": [1.0]}
    return Floor(value=value, **given | {"analytic": None, "evidence": {}} | facts)  # type: ignore[arg-type]


def test_a_stored_floor_is_replaced_only_when_it_is_beaten(tmp_path: Path) -> None:
    path = tmp_path / "floors" / "s.json"
    for value, stored in [(0.5, 0.5), (0.6, 0.5), (0.5 * (1 - 1e-12), 0.5), (0.4, 0.4)]:
        assert store_floor(path, a_floor(value)).value == stored
        assert read_floor(path) == store_floor(path, a_floor(value))


def test_a_proof_replaces_the_best_known_and_is_kept(tmp_path: Path) -> None:
    path = tmp_path / "s.json"
    store_floor(path, a_floor(1e-12))
    assert store_floor(path, a_floor(0.0, proof="it is zero")).proof == "it is zero"
    assert store_floor(path, a_floor(0.0)).proof == "it is zero"


def test_the_floor_of_another_state_of_the_scene_is_replaced(tmp_path: Path) -> None:
    path = tmp_path / "s.json"
    store_floor(path, a_floor(0.4))
    assert store_floor(path, a_floor(0.9, digest="e")).value == 0.9


def test_a_floor_that_is_kept_takes_over_the_analytic_start(tmp_path: Path) -> None:
    path = tmp_path / "s.json"
    store_floor(path, a_floor(0.4))
    assert store_floor(path, a_floor(0.5, analytic=0.7)) == a_floor(0.4, analytic=0.7)


def test_without_an_analytic_start_the_start_is_the_median_of_random_samples() -> None:
    assert [floor.start for floor in (a_floor(0.1), a_floor(0.1, sampled=0.8))] == [None, 0.8]
    assert a_floor(0.1, sampled=0.8, analytic=0.5).start == 0.5
    assert a_floor(0.1, sampled=0.5).fraction(0.2) == pytest.approx(0.75)
    assert a_floor(0.1, sampled=0.5).start_said == "the median of random samples"


def test_samples_without_an_equilibrium_are_left_out_of_the_median() -> None:
    bits = {"kind": "binary", "stiffness": 4.0}
    one = line([(0, 1)], [{"hold": [0], "push": {1: 0.4}}], stiffness=4.0, encoding=bits)
    assert compute_floor(one).sampled == pytest.approx(
        0.0, abs=1e-9
    )  # the bar alone holds the load, and no bar is no equilibrium
    two = line([(0, 1), (0, 1)], [{"hold": [0], "push": {1: 0.4}}], stiffness=4.0, encoding=bits)
    assert compute_floor(two).sampled == pytest.approx(0.5 * (0.4 / 4 - 0.4 / 8))  # two of three hold it with one bar


def test_fractions_go_from_the_analytic_start_to_the_floor() -> None:
    floor = a_floor(0.1, analytic=0.5)
    assert [floor.fraction(value) for value in (0.5, 0.2, 0.1)] == pytest.approx([0.0, 0.75, 1.0])
    assert a_floor(0.1).fraction(0.2) is None
    assert a_floor(0.1, analytic=0.1).fraction(0.2) is None
    assert (floor.is_beaten_by(0.0999), floor.is_beaten_by(0.1 * (1 - 1e-12))) == (True, False)
    assert not a_floor(0.0, proof="it is zero").is_beaten_by(-1e-20)


def test_a_file_that_is_no_floor_is_refused(tmp_path: Path) -> None:
    (tmp_path / "s.floor.json").write_text('{"value": 1}')
    with pytest.raises(UserError, match="holds no floor"):
        stored_floors("s", [tmp_path])
    assert stored_floors("t", [tmp_path]) == []


def test_a_run_s_point_makes_a_floor() -> None:
    setup = load_scene("paper-fem-2d-two-class").build()
    floor = floor_at(setup, np.array([5.0, 3.5]), "somebody")
    assert floor.value == setup.objective.evaluate(setup.encoding.decode(np.array([[5.0, 3.5]]))).values[0]
    assert floor.evidence["method"] == "somebody"


def changed(**tables: object) -> Scene:
    """paper-fem-2d with other tables."""
    data = load_scene("paper-fem-2d").model_dump(exclude_none=True) | tables
    return Scene.from_json(json.dumps(data))


def test_a_digest_is_of_what_decides_the_values() -> None:
    scene = load_scene("paper-fem-2d")
    cases = scene.load_cases.model_dump(exclude_none=True)
    beside = {"name": "other", "title": "Other", "budget": {"seconds": 1.0}, "optimizers": {}}
    assert changed(**beside, load_cases=cases | {"test": []}).digest() == scene.digest()
    assert changed(load_cases=cases | {"scale": 1.1}).digest() != scene.digest()
    assert changed(objective={"minimize": "least-squares"}).digest() != scene.digest()
    assert Scene.from_json(scene.to_json()).digest() == scene.digest()


def test_where_a_jacobian_is_too_large_gradients_lead_to_the_floor(monkeypatch: pytest.MonkeyPatch) -> None:
    setup = line(STAR, PULLS, stiffness=20.0, objective={"minimize": "least-squares"})
    by_jacobian = compute_floor(setup, starts=2)
    monkeypatch.setattr(floor_search, "LARGE", 1)
    by_gradient = compute_floor(setup, starts=2)
    assert by_gradient.evidence["method"] == "descents by the gradient, L-BFGS-B"
    assert by_gradient.value == pytest.approx(by_jacobian.value, rel=1e-9)
    assert by_gradient.point == [10.0, 10.0, 10.0]


def test_no_descent_ends_above_a_point_that_it_came_by() -> None:
    setup = load_scene("fem-2d-flat-cells").build()
    problem = Problem(setup.objective, setup.encoding, Budget(evaluations=10_000))
    start = analytic_start(setup)
    assert start is not None
    end = gradient_optimum(problem, start[0])
    assert problem.evaluate(end[None])[0] == problem.best_value < start[1]


def test_who_watches_is_told_of_every_descent() -> None:
    told: list[tuple[int, int, float]] = []
    setup = line(STAR, PULLS, stiffness=[3.0, 4.0, 8.0], encoding={"kind": "homogeneous", "upper": 10.0})
    floor = compute_floor(setup, starts=3, progress=lambda *facts: told.append(facts))
    assert [done for done, _, _ in told] == [1, 2, 3, 4, 5, 6, 7]  # three starts, twice, and the one optimum of squares
    assert {total for _, total, _ in told} == {7}
    assert told[-1][2] == floor.value


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * (name == "scale-50000")) for name in bundled_scenes()]
)
def test_the_stored_floor_of_a_bundled_scene_is_current_and_its_point_has_that_value(name: str) -> None:
    scene, floor = load_scene(name), read_floor(floor_file(name))
    assert floor is not None, f"compute it: springopt floor {name}"
    assert (floor.scene, floor.digest) == (name, scene.digest()), f"compute it again: springopt floor {name}"
    setup = scene.build()
    point = setup.encoding.encode(reference_row(setup)) if floor.point is None else np.array(floor.point)
    value = setup.objective.evaluate(setup.encoding.decode(point[None])).values[0]
    assert value == pytest.approx(floor.reached, rel=1e-7, abs=1e-9)
    assert floor.value == (floor.reached if floor.proof is None else 0.0)
    assert floor.proof is not None or {"method", "starts", "agreed", "spread"} <= set(floor.evidence)
    start = analytic_start(setup)
    assert floor.start is not None
    if start is not None:  # its plugin is installed
        assert floor.analytic == pytest.approx(start[1], rel=1e-7), f"compute it again: springopt floor {name}"


@pytest.mark.slow
@pytest.mark.parametrize("name", ["paper-fem-2d", "paper-fem-2d-4", "paper-fem-2d-8", "recovery-2d-sparse-noisy"])
def test_the_stored_floor_is_found_again_from_other_starts(name: str) -> None:
    stored = read_floor(floor_file(name))
    assert stored is not None
    found = compute_floor(load_scene(name).build(), starts=3, seed=100)
    assert found.value == pytest.approx(stored.value, rel=1e-9)
    assert found.evidence["agreed"] == 3


def test_no_known_floor_is_above_that_of_a_finer_encoding() -> None:
    coarse_to_fine = ("-homogeneous", "-two-class", "-three-class", "")
    floors = [read_floor(floor_file(f"paper-fem-2d{which}")) for which in coarse_to_fine]
    values = [floor.value for floor in floors if floor is not None]
    assert values == sorted(values, reverse=True)
    assert len(values) == 4
