"""Angle springs."""

import numpy as np
import pytest

import springopt as so
from springopt.effects.bending import lines
from springopt.effects.probe import probe

COUNT, KAPPA = 7, 5.0


def beam(d, count=COUNT):
    nodes = np.zeros((count, d))
    nodes[:, 0] = np.arange(count)
    return so.SpringLattice(nodes, [[i, i + 1] for i in range(count - 1)])


def tip(lattice, force, **options):
    """The displacement of the tip of a cantilever that holds its first two nodes."""
    forces = np.zeros(lattice.nodes.shape)
    forces[-1] = force
    case = so.LoadCase("tip", np.arange(lattice.node_count) < 2, forces)
    solution = so.Model(lattice, so.Bending(KAPPA), **options).solve(np.full(lattice.spring_count, 1e5), [case])
    assert solution.status[0] == "converged"
    return solution.displacements[0, -1]


#: Each angle turns by its moment over the stiffness, and swings the tip by its distance.
ARMS = COUNT - 1 - np.arange(1, COUNT - 1)
FLEXIBILITY = (ARMS**2).sum() / KAPPA


@pytest.mark.parametrize("options", [{}, {"engine": "sparse"}, {"kinematics": "linear"}], ids=str)
@pytest.mark.parametrize("force", [(0.0, 1e-7), (0.0, 0.0, -1e-7), (0.0, 2e-7, 1e-7)])
def test_a_cantilever_bends_by_the_moments_over_the_stiffness(force, options):
    found = tip(beam(len(force)), force, **options)
    np.testing.assert_allclose(found, FLEXIBILITY * np.array(force), rtol=1e-6, atol=1e-12)


@pytest.mark.parametrize("d", [2, 3])
def test_one_angle_turns_as_far_as_its_moment_says(d):
    force = np.zeros(d)
    force[-1] = -8.0
    found = tip(beam(d, 3), force)
    turn = np.arctan2(-found[-1], 1.0 + found[0])
    assert KAPPA * turn == pytest.approx(8.0 * np.cos(turn), rel=1e-3)  # the arm is longer by 1e-4
    assert turn > 0.9


@pytest.mark.parametrize("turn", [2.0, -2.0, 3.1])
def test_in_the_plane_an_angle_returns_to_its_rest_the_shorter_way(turn):
    lattice = so.SpringLattice([[0, 0], [1, 0], [1 + np.cos(turn), np.sin(turn)]], [[0, 1], [1, 2]])
    kernel = so.Bending(KAPPA, triples=[[0, 1, 2]]).potential(lattice)
    for more in (0.0, 0.5, -0.5, 3.0, 4.0):
        u = np.zeros((3, 2))
        u[2] = np.array([1 + np.cos(turn + more), np.sin(turn + more)]) - lattice.nodes[2]
        found = probe(kernel, lattice, u.reshape(1, -1), stiffness=np.ones(2), values=np.array([KAPPA]))
        wrapped = np.arctan2(np.sin(more), np.cos(more))
        assert found.energy[0] == pytest.approx(0.5 * KAPPA * wrapped**2, rel=1e-12, abs=1e-28)


@pytest.mark.parametrize("d", [2, 3])
def test_arms_that_are_bent_at_rest_are_at_rest(d):
    nodes = np.random.default_rng(3).standard_normal((4, d))
    lattice = so.SpringLattice(nodes, [[0, 1], [1, 2], [2, 3]])
    kernel = so.Bending(KAPPA, triples=[[0, 1, 2], [1, 2, 3]]).potential(lattice)
    found = probe(kernel, lattice, np.zeros((1, 4 * d)), stiffness=np.ones(3), values=np.array([KAPPA]))
    assert found.energy[0] < 1e-28
    assert np.abs(found.forces).max() < 1e-14


@pytest.mark.parametrize("d", [2, 3])
@pytest.mark.parametrize("size", [1e-12, 1e-8, 1e-4, 0.019, 0.021])
def test_small_turns_keep_their_digits(d, size):
    lattice = beam(d, 3)
    u = np.zeros((3, d))
    u[2, :2] = [-2.0 * np.sin(0.5 * size) ** 2, np.sin(size)]
    kernel = so.Bending(KAPPA).potential(lattice)
    found = probe(kernel, lattice, u.reshape(1, -1), stiffness=np.ones(2), values=np.array([KAPPA]))
    assert found.energy[0] == pytest.approx(0.5 * KAPPA * size**2, rel=1e-12)
    assert found.forces[0, 2 * d + 1] == pytest.approx(KAPPA * size * np.cos(size), rel=1e-12)


@pytest.mark.parametrize("d", [2, 3])
def test_a_full_fold_is_a_number_and_no_minimum(d):
    lattice = beam(d, 3)
    u = np.zeros((3, d))
    u[2, 0] = -2.0
    kernel = so.Bending(KAPPA).potential(lattice)
    found = probe(kernel, lattice, u.reshape(1, -1), stiffness=np.ones(2), values=np.array([KAPPA]))
    assert found.energy[0] == pytest.approx(0.5 * KAPPA * np.pi**2)
    assert np.isfinite(found.blocks).all()


def test_a_straight_column_carries_what_its_angles_hold_upright():
    """Two rigid arms on one angle, held below: the critical load is kappa over the length of the upper one."""
    lattice = so.SpringLattice([[0, 0], [0, 1], [0, 2]], [[0, 1], [1, 2]])
    for press, is_straight in ((0.95 * KAPPA, True), (1.05 * KAPPA, False)):
        case = so.LoadCase("press", [True, True, False], [[0, 0], [0, 0], [0, -press]])
        solution = so.Model(lattice, so.Bending(KAPPA)).solve([1e5, 1e5], [case])
        assert solution.status[0] == "converged"
        assert (abs(solution.displacements[0, 2, 0]) < 1e-6) == is_straight


def test_by_default_every_two_springs_in_line_are_an_angle():
    grid = so.SpringLattice.grid((3, 3))
    found = {tuple(line) for line in lines(grid).tolist()}
    straight = {(0, 1, 2), (3, 4, 5), (6, 7, 8), (0, 3, 6), (1, 4, 7), (2, 5, 8)}
    assert found == straight | {(0, 4, 8), (2, 4, 6)}


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"stiffness": [1.0, 2.0]}, r"stiffness must have the shape \(8,\), not \(2,\)"),
        ({"stiffness": 1.0, "triples": [[0, 1, 9]]}, r"triples\[0, 2\] is 9, but the nodes are numbered 0 to 8"),
        ({"stiffness": 1.0, "triples": [[0, 0, 1]]}, r"triples\[0\] has an arm of no length"),
        ({"stiffness": 1.0, "triples": [[0, 1]]}, r"triples must have the shape \(t, 3\)"),
    ],
)
def test_options_that_do_not_fit_are_refused(options, message):
    with pytest.raises(so.UserError, match=message):
        so.Model(so.SpringLattice.grid((3, 3)), so.Bending(**options))


def test_a_lattice_without_lines_needs_triples():
    with pytest.raises(so.UserError, match="no two of this lattice do; name triples"):
        so.Model(so.SpringLattice.grid((2, 2)), so.Bending(1.0))
