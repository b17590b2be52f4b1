"""Force balance: what it must find again exactly, what it can't tell, and its least squares against SciPy's."""

import numpy as np
import pytest
from scipy.optimize import lsq_linear
from springopt_balance import Balance, bounded_least_squares

from springopt import Budget, FemReference, Gravity, LoadCase, Model, Objective, Problem, SpringLattice, side
from springopt.encoding import Binary, Real, ThreeClass
from springopt.errors import NotServed, UserError
from springopt.runner import solve
from springopt.testing import check_optimizer

LATTICE = SpringLattice.grid((4, 4))
SIDES = {"left": "right", "right": "left", "bottom": "top", "top": "bottom"}
TOLERANCE = 1e-12


def load_cases(lattice, size=0.05):
    """Each side is held in turn and the opposite one pulled, in every direction."""
    cases = []
    for held, pulled in SIDES.items():
        for axis in range(lattice.dimension):
            forces = np.zeros(lattice.nodes.shape)
            forces[side(lattice, pulled), axis] = size
            cases.append(LoadCase(f"{pulled} {axis}", side(lattice, held), forces))
    return cases


def make_problem(model, stiffness, encoding, cases=None, weights=None):
    cases = load_cases(model.lattice) if cases is None else cases
    positions = model.solve(stiffness, cases, TOLERANCE).positions
    return Problem(Objective(model, cases, positions, "least-squares", weights), encoding, Budget(evaluations=9))


def found(problem, optimizer=None):
    (optimizer or Balance()).minimize(problem, np.random.default_rng(0))
    assert problem.meter.evaluations == 1
    return problem.best_point


def random_stiffness(lattice=LATTICE, absent=0.0, seed=1):
    rng = np.random.default_rng(seed)
    return np.where(rng.random(lattice.spring_count) < absent, 0.0, rng.uniform(2.0, 8.0, lattice.spring_count))


class TestExact:
    @pytest.mark.parametrize("measure", ["displacements", "forces"])
    @pytest.mark.parametrize("kinematics", ["exact", "linear"])
    def test_the_stiffness_of_a_mass_spring_reference_is_found_whatever_it_is(self, kinematics, measure):
        stiffness = random_stiffness(absent=0.1)
        model = Model(LATTICE, [Gravity((0.01, -0.02))], kinematics=kinematics)
        problem = make_problem(model, stiffness, Real(LATTICE))
        np.testing.assert_allclose(found(problem, Balance(measure=measure)), stiffness, atol=1e-8)
        assert problem.notes["imbalance"][0][1] < 1e-9

    def test_in_3d_and_with_prestrain(self):
        cube = SpringLattice.grid((3, 3, 3))
        lengths = cube.rest_lengths * np.random.default_rng(0).uniform(0.97, 1.0, cube.spring_count)
        body = SpringLattice(cube.nodes, cube.springs, lengths)
        stiffness = random_stiffness(body)
        np.testing.assert_allclose(found(make_problem(Model(body), stiffness, Real(body))), stiffness, atol=1e-8)

    def test_classes_and_intervals_that_do_not_begin_at_zero(self):
        encoding = ThreeClass(LATTICE, lower=1.0, upper=9.0)
        stiffness = encoding.decode([7.0, 3.0, 4.0])
        np.testing.assert_allclose(found(make_problem(Model(LATTICE), stiffness, encoding)), [7.0, 3.0, 4.0])
        narrow = Real(LATTICE, lower=1.0, upper=5.0)
        wanted = random_stiffness(absent=0.2)
        point = found(make_problem(Model(LATTICE), wanted, narrow))
        assert ((point >= 1.0) & (point <= 5.0)).all()

    def test_bits_are_relaxed_and_rounded(self):
        bits = (random_stiffness(absent=0.2) > 0).astype(float)
        encoding = Binary(LATTICE, stiffness=np.linspace(2.0, 6.0, LATTICE.spring_count))
        np.testing.assert_array_equal(found(make_problem(Model(LATTICE), encoding.decode(bits), encoding)), bits)

    def test_the_paper_s_scenes(self):
        run = solve("paper-stiffness-2d", "balance")
        np.testing.assert_allclose(run.stiffness, 5.0, rtol=1e-9)
        run = solve("paper-topology-3d", "balance")
        assert (np.count_nonzero(run.stiffness), run.evaluations) == (468, 1)
        begun = solve("paper-stiffness-2d", "random-search", start="balance", evaluations=3)
        assert begun.history[0].evaluations == 1


class TestWhatTheLoadsDoNotTell:
    def test_springs_between_held_nodes_get_the_common_number(self):
        cases = [case for case in load_cases(LATTICE) if case.name.startswith("right")]
        stiffness = np.full(LATTICE.spring_count, 4.0)
        hidden = side(LATTICE, "left")[LATTICE.springs].all(axis=1)
        point = found(make_problem(Model(LATTICE), stiffness, Real(LATTICE), cases))
        np.testing.assert_allclose(point[hidden], 4.0, rtol=1e-6)

    def test_a_single_load_case_is_balanced_by_what_is_closest_to_the_common_number(self):
        stiffness = random_stiffness()
        problem = make_problem(Model(LATTICE), stiffness, Real(LATTICE), load_cases(LATTICE)[:1])
        point = found(problem)
        assert problem.best_value <= 1e-12
        assert np.std(point) < np.std(stiffness)

    def test_a_load_case_of_no_weight_has_no_say(self):
        stiffness, cases = random_stiffness(), load_cases(LATTICE)
        problem = make_problem(Model(LATTICE), stiffness, Real(LATTICE), cases, [0.0] + [1.0] * (len(cases) - 1))
        problem.objective.reference_positions[0] += 0.3
        np.testing.assert_allclose(found(problem), stiffness, atol=1e-7)


class TestMeasure:
    def test_displacements_fit_a_finite_element_reference_better_than_forces(self):
        values = [solve("paper-fem-2d", Balance(measure=measure)).objective for measure in ("displacements", "forces")]
        assert values == pytest.approx([0.1210, 1.2754], abs=1e-4)

    def test_noise_is_damped_as_well_as_the_jacobian_allows(self):
        """The error stays within what an efficient estimator has, of covariance sigma^2 (J^T J)^-1."""
        stiffness, sigma = np.full(LATTICE.spring_count, 5.0), 1e-4
        problem = make_problem(Model(LATTICE), stiffness, Real(LATTICE), load_cases(LATTICE, 0.2))
        _, jacobian = problem.objective.jacobian(stiffness)
        errors = sigma * np.sqrt(np.linalg.inv(jacobian.T @ jacobian).diagonal())
        noise = sigma * np.random.default_rng(3).standard_normal(problem.objective.reference_positions.shape)
        problem.objective.reference_positions[:] += noise * [case.free for case in problem.objective.cases]
        off = (found(problem) - stiffness) / errors
        assert np.sqrt(np.mean(off**2)) < 1.5


class TestBoundedLeastSquares:
    def test_it_is_as_good_as_scipy_s(self):
        rng = np.random.default_rng(0)
        for _ in range(100):
            rows, size = rng.integers(1, 60), rng.integers(1, 30)
            matrix = rng.normal(size=(rows, size)) * 10 ** rng.uniform(-2, 2, size)
            upper = 10 ** rng.uniform(-1, 1, size)
            wanted = matrix @ (upper * rng.uniform(-0.5, 1.5, size)) + rng.normal(size=rows)
            z = bounded_least_squares(matrix, wanted, upper)
            assert ((z >= 0) & (z <= upper)).all()
            best = lsq_linear(matrix, wanted, (0, upper), method="bvls", max_iter=1000, tol=1e-14).cost
            assert 0.5 * np.square(matrix @ z - wanted).sum() <= best + 1e-12 * (wanted @ wanted)

    def test_no_rows_and_rows_of_zeros_tell_nothing(self):
        upper = np.array([1.0, 2.0])
        for rows in (0, 3):
            np.testing.assert_array_equal(bounded_least_squares(np.zeros((rows, 2)), np.zeros(rows), upper), [0, 0])


def test_it_keeps_the_contract_of_an_optimizer():
    check_optimizer(Balance)


class TestRefusals:
    def test_effects_with_forces_of_their_own(self):
        weights = Model(LATTICE, [Gravity((0.0, -0.1))], fitted=["gravity.mass"])
        problem = make_problem(weights, random_stiffness(), Real(LATTICE))
        with pytest.raises(UserError, match="balance knows springs and constant forces, and gravity adds forces"):
            found(problem)

    def test_prescribed_displacements_alone(self):
        moved = np.where(side(LATTICE, "right")[:, None], [0.1, 0.0], np.nan)
        case = LoadCase("stretch", side(LATTICE, "left"), np.zeros((16, 2)), moved)
        with pytest.raises(UserError, match="balance needs forces, and under prescribed displacements alone"):
            found(make_problem(Model(LATTICE), random_stiffness(), Real(LATTICE), [case]))

    def test_scenes_that_are_too_large_for_dense_least_squares(self, monkeypatch):
        monkeypatch.setattr("springopt_balance.LARGEST_BYTES", 1e5)
        with pytest.raises(NotServed, match=r"balance would need some .* GB of memory for 42 springs") as refusal:
            found(make_problem(Model(LATTICE), random_stiffness(), Real(LATTICE)))
        assert refusal.value.word == "memory"

    def test_options(self):
        with pytest.raises(UserError, match="option passes of balance is at least 1, not 0"):
            Balance(passes=0)


def test_a_finite_element_reference_in_3d_fits_into_the_box():
    cube = SpringLattice.grid((3, 3, 3))
    reference, cases = FemReference(cube, young=10.0, poisson=0.3), load_cases(cube)
    objective = Objective(Model(cube), cases, [reference.deform(case) for case in cases], "least-squares")
    problem = Problem(objective, Real(cube), Budget(evaluations=9))
    found(problem)
    assert problem.best_value < 0.2 * objective.evaluate(np.full((1, cube.spring_count), 5.0)).values[0]
