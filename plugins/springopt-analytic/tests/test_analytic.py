"""The formulas against closed forms: moduli, uniaxial tests, regular meshes; and through scenes and encodings."""

import numpy as np
import pytest
from springopt_analytic import Analytic, MacielAngles, MacielConnections, VanGelder

from springopt import (
    Budget,
    FemReference,
    Gravity,
    LoadCase,
    Model,
    Objective,
    Problem,
    SpringLattice,
    SpringReference,
    side,
)
from springopt.encoding import Homogeneous, Real, ThreeClass
from springopt.errors import UserError
from springopt.runner import solve
from springopt.testing import check_optimizer

FORMULAS = (Analytic, VanGelder, MacielAngles, MacielConnections)
every_formula = pytest.mark.parametrize("formula", FORMULAS, ids=lambda formula: formula.name)
PULL = 0.01


def pulled(lattice, size=PULL):
    """Held on the left along x alone, and nowhere else more than needed; pulled evenly on the right, by `size` in all.

    The forces on the side are those of an even pressure: nodes at its ends have half.
    """
    supports = np.zeros(lattice.nodes.shape, dtype=bool)
    supports[side(lattice, "left"), 0] = True
    corner = np.all(lattice.nodes == lattice.nodes.min(axis=0), axis=1)
    supports[corner] = True
    if lattice.dimension == 3:
        supports[np.all(lattice.nodes[:, [0, 2]] == 0, axis=1), 2] = True
    low, high = lattice.nodes.min(axis=0), lattice.nodes.max(axis=0)
    ends = np.count_nonzero((lattice.nodes[:, 1:] == low[1:]) | (lattice.nodes[:, 1:] == high[1:]), axis=1)
    weights = np.where(side(lattice, "right"), 0.5**ends, 0.0)
    forces = np.zeros(lattice.nodes.shape)
    forces[:, 0] = size * weights / weights.sum()
    return LoadCase("pull", supports, forces)


def make_problem(reference, lattice, cases, encoding=None, **model):
    positions = [reference.deform(case) for case in cases]
    objective = Objective(Model(lattice, **model), cases, positions, "least-squares", reference=reference)
    return Problem(objective, encoding or Real(lattice, upper=1e3), Budget(evaluations=10))


def found(formula, problem):
    formula.minimize(problem, np.random.default_rng(0))
    assert problem.meter.evaluations == 1
    return problem.best_point


def of_grid(formula, shape, spacing=1.0, **material):
    """Lattice, and the stiffness that a formula gives its springs."""
    lattice = SpringLattice.grid(shape, spacing=spacing)
    reference = FemReference(lattice, **{"young": 1.0, "poisson": 0.3} | material)
    return lattice, found(formula, make_problem(reference, lattice, [pulled(lattice)]))


def by_kind(lattice, stiffness):
    """The one stiffness of each kind: (squared length, on how many sides of the grid) -> stiffness."""
    low, high = lattice.nodes.min(axis=0), lattice.nodes.max(axis=0)
    ends = lattice.nodes[lattice.springs]
    on_side = ((ends == low) | (ends == high)) & (ends[:, :1] == ends[:, 1:])
    squares = np.square(ends[:, 1] - ends[:, 0]).sum(axis=1).round().astype(int)
    kinds = list(zip(squares.tolist(), on_side[:, 0].sum(axis=1).tolist(), strict=True))
    means = {kind: np.mean([k for k, own in zip(stiffness, kinds, strict=True) if own == kind]) for kind in set(kinds)}
    np.testing.assert_allclose(stiffness, [means[kind] for kind in kinds], rtol=1e-9)
    return means


class TestAnalytic:
    @pytest.mark.parametrize(
        ("shape", "spacing"),
        [((2, 2), 1.0), ((5, 5), 1.0), ((7, 3), 0.5), ((4, 6), (1.0, 0.8)), ((3, 3, 3), 1.0), ((5, 2, 4), 2.0)],
    )
    @pytest.mark.parametrize("keep", ["young", "axes"])
    def test_uniaxial_tests_are_exact_on_every_grid(self, shape, spacing, keep):
        thickness = 0.7 if len(shape) == 2 else 1.0
        lattice, stiffness = of_grid(Analytic(keep=keep), shape, spacing, young=3.0, poisson=0.2, thickness=thickness)
        solution = Model(lattice, kinematics="linear").solve(stiffness, [pulled(lattice)])
        section = thickness * np.prod(np.ptp(lattice.nodes, axis=0)[1:])
        strain = PULL / (3.0 * section)
        contraction = {"young": {2: 1 / 3, 3: 1 / 4}[lattice.dimension], "axes": 0.2}[keep]
        wanted = strain * np.array([1.0, *[-contraction] * (lattice.dimension - 1)]) * lattice.nodes
        np.testing.assert_allclose(solution.displacements[0], wanted, atol=1e-12)

    def test_in_2d_straight_springs_have_twice_the_stiffness_of_diagonals_and_half_of_it_on_the_boundary(self):
        kinds = by_kind(*of_grid(Analytic(), (5, 5)))
        assert kinds == pytest.approx({(1, 0): 0.75, (1, 1): 0.375, (2, 0): 0.375})
        kinds = by_kind(*of_grid(Analytic(keep="moduli"), (5, 5)))
        assert kinds == pytest.approx({(1, 0): 0.7326, (1, 1): 0.3663, (2, 0): 0.3663}, abs=1e-4)

    def test_in_3d_faces_carry_half_and_edges_a_quarter_of_an_isotropic_lattice(self):
        kinds = by_kind(*of_grid(Analytic(), (4, 4, 4), poisson=0.25))
        shear, body = 0.4, kinds[3, 0]  # C44 = E / (2 (1 + 1/4))
        straight, face = shear + 4 / 3 * body, shear - 4 / 3 * body
        wanted = {(1, 0): 1.0, (1, 1): 0.5, (1, 2): 0.25}
        assert kinds == pytest.approx(
            {kind: straight * share for kind, share in wanted.items()} | {(2, 0): face, (2, 1): face / 2, (3, 0): body}
        )

    def test_a_body_with_the_lattice_s_own_poisson_s_ratio_is_kept_whole(self):
        for shape, poisson in (((4, 4), 1 / 3), ((3, 3, 3), 1 / 4)):
            answers = [of_grid(Analytic(keep=keep), shape, poisson=poisson)[1] for keep in ("young", "moduli", "axes")]
            np.testing.assert_allclose(answers[1:], [answers[0]] * 2)

    def test_plane_strain_is_plane_stress_of_other_constants(self):
        strain = of_grid(Analytic(keep="axes"), (4, 4), poisson=0.2, plane="strain")[1]
        stress = of_grid(Analytic(keep="axes"), (4, 4), young=1 / 0.96, poisson=0.25)[1]
        np.testing.assert_allclose(strain, stress)


class TestVanGelder:
    def test_equilateral_triangles_are_exact(self):
        nodes = np.array([[i + j / 2, j * 3**0.5 / 2] for j in range(3) for i in range(3)])
        cells = [[a, a + 1, a + 3] for a in (0, 1, 3, 4)] + [[a + 1, a + 4, a + 3] for a in (0, 1, 3, 4)]
        lattice = SpringLattice.from_mesh(_mesh(nodes, cells))
        reference = FemReference(lattice, young=2.0, poisson=1 / 3)
        case = LoadCase("pull", side(lattice, "bottom"), np.full(nodes.shape, PULL))
        stiffness = found(VanGelder(), make_problem(reference, lattice, [case]))
        np.testing.assert_allclose(stiffness, 2.0 * 3**0.5 / 4 * np.where(lattice.boundary, 1, 2))

    def test_a_block_counts_all_its_divisions_alike(self):
        square = by_kind(*of_grid(VanGelder(), (4, 4), thickness=0.5))
        assert square == pytest.approx({(1, 0): 0.5, (1, 1): 0.25, (2, 0): 0.125})
        cube = by_kind(*of_grid(VanGelder(), (4, 4, 4)))
        assert cube == pytest.approx(
            {(1, 0): 1, (1, 1): 1 / 2, (1, 2): 1 / 4, (2, 0): 1 / 6, (2, 1): 1 / 12, (3, 0): 1 / 12}
        )

    def test_triangles_of_a_grid_have_their_own_diagonals_alone(self):
        lattice = SpringLattice.grid((3, 3), cell="triangle")
        stiffness = found(
            VanGelder(), make_problem(FemReference(lattice, young=1.0, poisson=0.3), lattice, [pulled(lattice)])
        )
        assert sorted(set(stiffness[~lattice.straight].round(12))) == [0.0, 0.5]


class TestMaciel:
    def test_by_angles_a_grid_without_diagonals_is_a_bundle_of_bars(self):
        lattice = SpringLattice.grid((5, 4), neighbourhood="von-neumann")
        reference = FemReference(lattice, young=2.0, poisson=0.0)
        stiffness = found(MacielAngles(), make_problem(reference, lattice, [pulled(lattice)]))
        np.testing.assert_allclose(stiffness, np.where(lattice.boundary, 1.0, 2.0))

    def test_inside_a_square_grid_both_rules_give_two_thirds_and_one_third(self):
        for formula in (MacielAngles(), MacielConnections()):
            lattice, stiffness = of_grid(formula, (6, 6))
            inside = np.all((lattice.nodes[lattice.springs] >= 1) & (lattice.nodes[lattice.springs] <= 4), axis=(1, 2))
            np.testing.assert_allclose(stiffness[inside], np.where(lattice.straight[inside], 2 / 3, 1 / 3))


@every_formula
class TestEveryFormula:
    def test_stiffness_is_in_proportion_to_young_and_thickness_and_free_of_the_scale_in_2d(self, formula):
        _, one = of_grid(formula(), (4, 5))
        np.testing.assert_allclose(of_grid(formula(), (4, 5), 3.0, young=2.0, thickness=0.25)[1], 0.5 * one)

    def test_young_s_modulus_of_a_reference_of_springs_is_found_from_its_deformation(self, formula):
        lattice, one = of_grid(formula(), (4, 4), poisson=1 / 3)
        cases = [pulled(lattice, 0.5)]
        problem = make_problem(SpringReference(Model(lattice), 7.0 * one), lattice, cases)
        np.testing.assert_allclose(found(formula(), problem), 7.0 * one)
        assert problem.best_value <= 1e-15

    def test_a_point_is_the_closest_of_the_encoding(self, formula):
        lattice, stiffness = of_grid(formula(), (4, 4))
        reference, cases = FemReference(lattice, young=1.0, poisson=0.3), [pulled(lattice)]
        for encoding in (Homogeneous(lattice), ThreeClass(lattice), Real(lattice, lower=0.3, upper=0.5)):
            point = found(formula(), make_problem(reference, lattice, cases, encoding))
            np.testing.assert_allclose(point, encoding.encode(stiffness))

    def test_a_binary_scene_is_refused(self, formula):
        with pytest.raises(UserError, match=f"{formula.name} needs a real encoding"):
            solve("paper-topology-2d-isotropic", formula())

    def test_it_keeps_the_contract_of_an_optimizer(self, formula):
        check_optimizer(formula)

    def test_an_option_takes_the_place_of_the_reference(self, formula):
        np.testing.assert_allclose(of_grid(formula(young=4.0), (3, 3))[1], 4.0 * of_grid(formula(), (3, 3))[1])

    def test_what_it_can_not_do_without_it_says_in_one_sentence(self, formula):
        lattice = SpringLattice.grid((3, 3))
        bare = SpringLattice(lattice.nodes, lattice.springs)
        reference, case = SpringReference(Model(bare), 1.0), LoadCase("pull", side(bare, "left"), np.zeros((9, 2)))
        with pytest.raises(UserError, match=f"{formula.name} needs the cells of the body"):
            found(formula(), make_problem(reference, bare, [case]))
        with pytest.raises(UserError, match=f"{formula.name} can't tell Young's modulus .* --set young=NUMBER"):
            found(formula(), make_problem(reference, lattice, [case]))
        for option in ({"young": 0.0}, {"poisson": 0.5}):
            with pytest.raises(UserError, match=f"option {next(iter(option))} of {formula.name}"):
                formula(**option)

    def test_it_reaches_what_the_readme_says_and_starts_another_optimizer(self, formula):
        told = {"analytic": 0.1252, "van-gelder": 0.3591, "maciel-angles": 0.2489, "maciel-connections": 0.1872}
        run = solve("paper-fem-2d", "random-search", start=formula.name, evaluations=3)
        assert (run.start, run.history[0].evaluations) == (formula.name, 1)
        assert run.history[0].value == pytest.approx(told[formula.name], abs=1e-4)


def _mesh(nodes, cells):
    import meshio

    return meshio.Mesh(nodes, [("triangle", np.array(cells))])


def test_the_weight_counts_as_it_is_stated_where_its_masses_are_fitted():
    lattice = SpringLattice.grid((4, 4))
    case, gravity = pulled(lattice), Gravity((0.0, -0.05))
    reference = SpringReference(Model(lattice, gravity), 5.0)
    points = []
    for fitted in ((), ("gravity.mass",)):
        problem = make_problem(reference, lattice, [case], effects=gravity, fitted=fitted)
        Analytic().minimize(problem, np.random.default_rng(0))
        points.append(problem.best_point)
    np.testing.assert_array_equal(points[0], points[1])
