"""What springs pull with where all positions are known: at an equilibrium it balances the loads."""

import numpy as np
import pytest

from springopt import Gravity, LoadCase, Model, SpringLattice, side

TOLERANCE = 1e-12


def bodies():
    square, cube = SpringLattice.grid((4, 3)), SpringLattice.grid((3, 3, 2), spacing=(1.0, 0.7, 1.3))
    rng = np.random.default_rng(3)
    shaken = SpringLattice(square.nodes, square.springs, square.rest_lengths * rng.uniform(0.9, 1.1, 29))
    tied = SpringLattice(square.nodes, square.springs, np.where(np.arange(29) % 5, square.rest_lengths, 0.0))
    return {"2D": square, "3D": cube, "prestrain": shaken, "zero rest lengths": tied}


@pytest.mark.parametrize("kinematics", ["exact", "linear"])
@pytest.mark.parametrize("name", bodies())
def test_at_an_equilibrium_the_springs_balance_the_loads(name, kinematics):
    lattice, rng = bodies()[name], np.random.default_rng(1)
    stiffness = rng.uniform(2.0, 8.0, lattice.spring_count)
    model = Model(lattice, [Gravity(rng.normal(0.0, 0.02, lattice.dimension))], kinematics=kinematics)
    forces = rng.normal(0.0, 0.05, (2, *lattice.nodes.shape))
    cases = [LoadCase(name, side(lattice, name), f) for name, f in zip(("left", "bottom"), forces, strict=True)]
    solution = model.solve(stiffness, cases, TOLERANCE)
    pulls = stiffness[:, None] * model.forces_per_stiffness(solution.positions)
    for case, pull in zip(cases, pulls, strict=True):
        balance = case.forces + model.constant_forces()
        np.add.at(balance, lattice.springs[:, 0], pull)
        np.subtract.at(balance, lattice.springs[:, 1], pull)
        assert np.abs(balance[case.free]).max() <= 1e-12


def test_a_spring_keeps_its_digits_where_it_hardly_moves():
    lattice = SpringLattice([[0.0, 0.0], [1.0, 0.0]], [[0, 1]])
    positions = np.array([[[0.0, 0.0], [1.0 + 1e-9, 0.0]]])
    pull = Model(lattice).forces_per_stiffness(positions)
    np.testing.assert_allclose(pull[0, 0], [(1.0 + 1e-9) - 1.0, 0.0], rtol=1e-15)
