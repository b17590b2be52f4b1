"""The masses of nodes."""

import numpy as np
import pytest

import springopt as so

GRID, SOLID = so.SpringLattice.grid((4, 3)), so.SpringLattice.grid((3, 3, 2))


@pytest.mark.parametrize("lattice", [GRID, SOLID], ids=["2D", "3D"])
def test_a_density_gives_every_node_its_share_of_the_body(lattice):
    terms = so.Model(lattice, so.Inertia(density=3.0)).terms
    masses = terms.masses(terms.defaults)
    assert masses.sum() == pytest.approx(3.0 * len(lattice.cells))
    assert masses[0] == pytest.approx(3.0 / 2**lattice.dimension)


def test_masses_are_columns_of_a_candidate():
    terms = so.Model(GRID, so.Inertia(mass=2.0), fitted=["inertia.mass"]).terms
    rows = terms.rows(np.concatenate([np.ones((2, GRID.spring_count)), [[5.0], [7.0]]], axis=1))
    masses = terms.masses(rows[:, GRID.spring_count :])
    np.testing.assert_array_equal(masses, np.repeat([[5.0], [7.0]], GRID.node_count, axis=1))


@pytest.mark.parametrize("options", [{}, {"mass": 1.0, "density": 1.0}])
def test_masses_are_stated_one_way(options):
    with pytest.raises(so.UserError, match="masses are given by one of mass and density"):
        so.Model(GRID, so.Inertia(**options))


def test_nothing_of_it_is_felt_at_rest():
    case = so.LoadCase("pull", so.side(GRID, "left"), np.full(GRID.nodes.shape, 0.01))
    known, found = (so.Model(GRID, effects).solve(np.full(29, 3.0), [case]) for effects in ([], so.Inertia(mass=1.0)))
    np.testing.assert_array_equal(found.positions, known.positions)
