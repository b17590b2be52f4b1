"""Equilibria at large strain: bars and shears by their formulas, and what is refused."""

import numpy as np
import pytest
from scipy.optimize import brentq

from springopt.errors import UserError
from springopt.lattice import SpringLattice, side
from springopt.load_case import LoadCase
from springopt.reference.fem import FemReference

YOUNG, POISSON = 7.0, 0.3
SHEAR, LAME = YOUNG / (2 * (1 + POISSON)), YOUNG * POISSON / ((1 + POISSON) * (1 - 2 * POISSON))
LAWS = ["saint-venant-kirchhoff", "neo-hookean"]
SHAPES = {"triangle": (3, 2), "quad": (3, 2), "tetra": (3, 2, 2), "hexahedron": (3, 2, 2)}
BODIES = [
    *((cell, plane, "standard") for cell in ("triangle", "quad") for plane in ("stress", "strain")),
    ("tetra", "space", "standard"),
    ("hexahedron", "space", "standard"),
    ("quad", "strain", "b-bar"),
    ("hexahedron", "space", "b-bar"),
]
every_body = pytest.mark.parametrize(("cell", "plane", "formulation"), BODIES)
every_law = pytest.mark.parametrize("law", LAWS)


def reference_of(lattice, law, plane="stress", formulation="standard", **changes):
    plane = "stress" if plane == "space" else plane
    options = {"young": YOUNG, "poisson": POISSON, "law": law, "plane": plane, "formulation": formulation} | changes
    return FemReference(lattice, **options)


def on_rollers(lattice):
    """Supports that let a bar along x narrow freely, shape (n, d)."""
    names = ["left", "bottom"] if lattice.dimension == 2 else ["left", "front", "bottom"]
    return np.stack([side(lattice, name) for name in names], axis=1)


def bar(law, plane, stretch):
    """Stress of a bar [force / area at rest] and the stretch across it, for this stretch along it."""
    if law == "saint-venant-kirchhoff":
        modulus, lateral = (
            (YOUNG / (1 - POISSON**2), POISSON / (1 - POISSON)) if plane == "strain" else (YOUNG, POISSON)
        )
        strain = (stretch**2 - 1) / 2
        return modulus * strain * stretch, np.sqrt(1 - 2 * lateral * strain)
    power = 1 if plane == "strain" else 2  # how many directions narrow

    def across(t):
        return SHEAR * (t**2 - 1) + LAME * np.log(stretch * t**power)

    t = brentq(across, 0.1, 3.0, xtol=1e-15)
    return SHEAR * (stretch - 1 / stretch) + LAME * np.log(stretch * t**power) / stretch, t


@every_law
@every_body
@pytest.mark.parametrize("stretch", [0.8, 1.4])
def test_a_bar_pulled_to_a_stretch_answers_with_its_formula(law, cell, plane, formulation, stretch):
    lattice = SpringLattice.grid(SHAPES[cell], cell=cell)
    right, prescribed = side(lattice, "right"), np.where(on_rollers(lattice), 0.0, np.nan)
    prescribed[right, 0] = (stretch - 1) * 2.0
    case = LoadCase("pulled", on_rollers(lattice), np.zeros(lattice.nodes.shape), prescribed)
    reference = reference_of(lattice, law, plane, formulation)
    positions = reference.deform(case)
    stress, lateral = bar(law, plane, stretch)
    np.testing.assert_allclose(positions, lattice.nodes * [stretch, *[lateral] * (lattice.dimension - 1)], atol=1e-9)
    force = reference.body.internal_forces(positions - lattice.nodes)[right, 0].sum()
    assert force == pytest.approx(stress, rel=1e-9)


@every_law
@every_body
def test_a_bar_pulled_by_a_force_stretches_as_its_formula_says(law, cell, plane, formulation):
    lattice = SpringLattice.grid(SHAPES[cell], cell=cell)
    stress, lateral = bar(law, plane, 1.5)
    # Forces of a uniform stress are the internal forces of a small uniform strain without Poisson's effect.
    unit = (
        reference_of(lattice, "linear", poisson=0.0, young=1.0).stiffness_matrix
        @ (lattice.nodes * np.eye(3)[0, : lattice.dimension]).ravel()
    )
    forces = np.where(side(lattice, "right")[:, None], stress * unit.reshape(lattice.nodes.shape), 0.0)
    positions = reference_of(lattice, law, plane, formulation).deform(LoadCase("pulled", on_rollers(lattice), forces))
    np.testing.assert_allclose(positions, lattice.nodes * [1.5, *[lateral] * (lattice.dimension - 1)], atol=1e-8)


@every_law
@every_body
def test_simple_shear_answers_with_its_formula(law, cell, plane, formulation):
    """Stresses P_12 and P_22 by the first and second axis on the face across the second."""
    lattice, amount = SpringLattice.grid([2] * len(SHAPES[cell]), cell=cell), 0.6
    displacements = np.zeros(lattice.nodes.shape)
    displacements[:, 0] = amount * lattice.nodes[:, 1]
    case = LoadCase("sheared", np.ones(lattice.nodes.shape, bool), np.zeros(lattice.nodes.shape), displacements)
    reference = reference_of(lattice, law, plane, formulation)
    forces = reference.body.internal_forces(reference.deform(case) - lattice.nodes)[lattice.nodes[:, 1] == 1.0].sum(
        axis=0
    )
    if law == "neo-hookean":
        expected = [SHEAR * amount, 0.0]
    else:
        lame = YOUNG * POISSON / (1 - POISSON**2) if plane == "stress" else LAME
        up = (lame / 2 + SHEAR) * amount**2
        expected = [SHEAR * amount + amount * up, up]
    np.testing.assert_allclose(forces[:2], expected, atol=1e-12)


@every_law
def test_a_cantilever_bends_far_and_the_answer_is_in_balance(law):
    lattice = SpringLattice.grid((21, 3), spacing=(0.5, 0.25))
    forces = np.zeros(lattice.nodes.shape)
    forces[side(lattice, "right"), 1] = 0.004 * YOUNG
    case = LoadCase("bent", side(lattice, "left"), forces)
    reference = reference_of(lattice, law)
    displacements = reference.deform(case) - lattice.nodes
    assert displacements[:, 1].max() > 6.0
    left = (reference.body.internal_forces(displacements) - forces)[case.free]
    assert np.linalg.norm(left) < 1e-9 * np.linalg.norm(forces)


@every_law
def test_a_body_turned_by_its_supports_stays_undeformed(law):
    lattice = SpringLattice.grid((4, 4))
    angle = np.deg2rad(60.0)
    turned = lattice.nodes @ np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    case = LoadCase(
        "turned",
        side(lattice, "left"),
        np.zeros((16, 2)),
        np.where(side(lattice, "left")[:, None], turned - lattice.nodes, np.nan),
    )
    np.testing.assert_allclose(reference_of(lattice, law).deform(case), turned, atol=1e-9)


@every_law
def test_units_do_not_change_the_answer(law):
    lattice = SpringLattice.grid((4, 3))
    forces = 0.3 * side(lattice, "right")[:, None] * np.array([0.5, 1.0])
    answers = []
    for length, force in [(1.0, 1.0), (1e-3, 1e6), (1e3, 1e-6)]:
        body = SpringLattice.grid((4, 3), spacing=length)
        reference = FemReference(body, young=YOUNG * force / length**2, poisson=POISSON, law=law, thickness=length)
        answers.append(reference.deform(LoadCase("pulled", side(body, "left"), forces * force)) / length)
    np.testing.assert_allclose(answers[1], answers[0], rtol=1e-8, atol=1e-9)
    np.testing.assert_allclose(answers[2], answers[0], rtol=1e-8, atol=1e-9)


def crushed(reference, amount, d=2):
    lattice = SpringLattice.grid((3, 3))
    right = side(lattice, "right")
    prescribed = np.where(side(lattice, "left")[:, None], 0.0, np.nan) * np.ones(d)
    prescribed[right] = [-amount, 0.0]
    return reference.deform(LoadCase("crushed", side(lattice, "left"), np.zeros((9, 2)), prescribed))


@every_law
def test_a_body_pushed_through_itself_is_refused_with_the_share_that_it_bears(law):
    reference = reference_of(SpringLattice.grid((3, 3)), law)
    with pytest.raises(
        UserError, match=r"in load case 'crushed' beyond 0\.\d+ of its load, where .*; reduce the load"
    ) as caught:
        crushed(reference, 2.5)
    assert str(caught.value).count(". ") == 0


def test_saint_venant_loses_stability_in_compression():
    """A bar between rollers: dP / dl = E (3 l^2 - 1) / 2 vanishes at l = 0.577, the largest force that it bears."""
    lattice = SpringLattice.grid((3, 2))
    most = YOUNG / 2 * (1 / np.sqrt(3) - 3**-1.5)
    supports, right = on_rollers(lattice), side(lattice, "right")
    supports[:, 1] = True  # so that it can't buckle
    for share, is_borne in [(0.98, True), (1.02, False)]:
        forces = np.where(right[:, None], [-share * most / 2, 0.0], 0.0)
        reference, case = (
            reference_of(lattice, "saint-venant-kirchhoff", poisson=0.0),
            LoadCase("pushed", supports, forces),
        )
        if is_borne:
            assert reference.deform(case)[right, 0].min() > 2 / np.sqrt(3)
        else:
            with pytest.raises(UserError, match=r"beyond 0\.9[78]\d* of its load"):
                reference.deform(case)


@every_law
def test_a_column_is_refused_beyond_its_buckling_load(law):
    """Euler's load of a clamped column, pi^2 E I / (4 L^2); quadrilaterals are stiff in bending, so on small cells."""
    lattice = SpringLattice.grid((41, 5), spacing=0.25)
    euler = np.pi**2 * YOUNG / 12 / (4 * 10.0**2)
    forces = np.zeros(lattice.nodes.shape)
    forces[side(lattice, "right"), 0] = -2 * euler * np.array([0.5, 1, 1, 1, 0.5]) / 4
    with pytest.raises(UserError, match="it becomes unstable") as caught:
        reference_of(lattice, law, poisson=0.0).deform(LoadCase("pushed", side(lattice, "left"), forces))
    share = float(str(caught.value).partition("beyond ")[2].split()[0])
    assert 2 * share == pytest.approx(1.0, abs=0.06)


@every_law
def test_no_load_moves_nothing(law):
    lattice = SpringLattice.grid((3, 3, 3))
    case = LoadCase("nothing", side(lattice, "left"), np.zeros(lattice.nodes.shape))
    np.testing.assert_array_equal(reference_of(lattice, law).deform(case), lattice.nodes)


@every_law
def test_supports_that_leave_the_body_free_are_refused(law):
    lattice = SpringLattice.grid((3, 3))
    with pytest.raises(UserError, match="'free' leaves the body free to move in 3 rigid modes"):
        reference_of(lattice, law).deform(LoadCase("free", np.zeros(9, bool), np.zeros((9, 2))))


@every_law
def test_times_are_refused_at_large_strain(law):
    lattice = SpringLattice.grid((3, 3))
    case = LoadCase("moving", side(lattice, "left"), np.zeros((9, 2)), times=[1.0])
    with pytest.raises(UserError, match=f"'moving' has times, but the law '{law}' knows equilibria only"):
        reference_of(lattice, law, density=1.0).deform(case)


def test_an_unknown_law_is_refused():
    with pytest.raises(UserError, match="law must be one of linear, saint-venant-kirchhoff, neo-hookean, not 'hooke'"):
        reference_of(SpringLattice.grid((3, 3)), "hooke")
