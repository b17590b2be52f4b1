"""Rest lengths that are scaled, as data and as a parameter."""

import numpy as np
import pytest

import springopt as so

GRID = so.SpringLattice.grid((4, 3))
SOLID = so.SpringLattice.grid((3, 3, 3))
CLASSES = {"boundary straight": 0.9, "diagonal": 0.95}


def pulled(lattice):
    forces = np.where(so.side(lattice, "right")[:, None], np.linspace(0.3, 0.1, lattice.dimension), 0.0)
    return so.LoadCase("pull", so.side(lattice, "left"), forces)


def test_two_springs_settle_where_their_tensions_agree():
    lattice = so.SpringLattice([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]], [[0, 1], [1, 2]])
    case = so.LoadCase("none", [True, False, True], np.zeros((3, 2)))
    solution = so.Model(lattice, so.Prestress(scale=[0.5, 0.8])).solve([3.0, 7.0], [case])
    assert solution.status[0] == "converged"  # across, the tension holds it
    x = (3.0 * 0.5 + 7.0 * (2 - 0.8)) / 10.0
    np.testing.assert_allclose(solution.positions[0, 1], [x, 0.0], atol=1e-12)


def test_a_tense_string_sags_by_its_tension():
    nodes = np.column_stack([np.arange(9.0), np.zeros(9)])
    string = so.SpringLattice(nodes, [[i, i + 1] for i in range(8)])
    forces = np.where(np.arange(9)[:, None] == 4, [0.0, -1e-6], 0.0)
    case = so.LoadCase("weight", np.isin(np.arange(9), [0, 8]), forces)
    solution = so.Model(string, so.Prestress(scale=0.75)).solve(np.full(8, 4.0), [case])
    assert solution.displacements[0, 4, 1] == pytest.approx(-1e-6 * 8.0 / 4.0 / (4.0 * 0.25), rel=1e-8)


@pytest.mark.parametrize("lattice", [GRID, SOLID], ids=["2D", "3D"])
@pytest.mark.parametrize("kinematics", ["exact", "linear"])
@pytest.mark.parametrize("option", ["one", "each", "classes"])
def test_prestress_by_data_is_prestress_fitted(lattice, kinematics, option):
    scales = np.random.default_rng(1).uniform(0.85, 1.0, lattice.spring_count)
    options = {"one": {"scale": 0.9}, "each": {"scale": scales}, "classes": {"classes": CLASSES}}[option]
    effect = so.Prestress(**options)
    data = so.Model(lattice, effect, kinematics=kinematics)
    fitted = so.Model(lattice, effect, kinematics=kinematics, fitted=["prestress.scale"])
    stiffness = np.full(lattice.spring_count, 4.0)
    given, found = (model.solve(stiffness, [pulled(lattice)]) for model in (data, fitted))
    assert given.status[0] == found.status[0] == "converged"
    np.testing.assert_allclose(found.displacements, given.displacements, atol=1e-9)
    assert found.energy[0] == pytest.approx(given.energy[0], rel=1e-9)


def test_a_class_of_springs_is_scaled_and_the_others_are_not():
    lattice = so.Model(GRID, so.Prestress(classes=CLASSES)).terms.lattice
    scale = lattice.rest_lengths / GRID.rest_lengths
    np.testing.assert_allclose(scale[~GRID.straight], 0.95)
    np.testing.assert_allclose(scale[GRID.straight & GRID.boundary], 0.9)
    np.testing.assert_allclose(scale[GRID.straight & ~GRID.boundary], 1.0)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({}, "one of scale and classes"),
        ({"scale": 1.0, "classes": CLASSES}, "one of scale and classes"),
        ({"scale": [0.9, 0.9]}, r"scale must have the shape \(29,\), not \(2,\)"),
        ({"scale": -0.5}, r"scale is -0.5, but it must be finite and not negative"),
        ({"classes": {"diagonals": 0.9}}, "not 'diagonals'. Did you mean 'diagonal'"),
        ({"classes": {"straight": 0.9, "inner straight": 0.8}}, "straight and inner straight have springs in common"),
    ],
)
def test_options_that_do_not_fit_are_refused(options, message):
    with pytest.raises(so.UserError, match=message):
        so.Model(GRID, so.Prestress(**options))
