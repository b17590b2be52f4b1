"""Nodes on a plane and at a sphere."""

import numpy as np
import pytest

import springopt as so
from springopt.effects.probe import probe

GRID, SOLID = so.SpringLattice.grid((5, 4)), so.SpringLattice.grid((4, 3, 3))
both = pytest.mark.parametrize("lattice", [GRID, SOLID], ids=["2D", "3D"])
every_engine = pytest.mark.parametrize("engine", ["lanes", "sparse", "iterative"])


def up(lattice):
    return np.eye(lattice.dimension)[-1]


def not_adrift(lattice):
    """Supports along the plane alone, as few as keep a body from sliding and turning there."""
    supports = np.zeros(lattice.nodes.shape, dtype=bool)
    supports[0, :-1] = True
    if lattice.dimension == 3:
        supports[1, 1] = True  # along x from node 0: it keeps the body from turning about the normal
    return supports


@every_engine
@both
def test_a_block_on_a_plane_pushes_it_with_its_weight(lattice, engine):
    plane = so.PlaneContact(200.0, np.zeros(lattice.dimension), 3.0 * up(lattice))
    gravity = so.Gravity(-0.05 * up(lattice), mass=1.0)
    case = so.LoadCase("rest", not_adrift(lattice), np.zeros(lattice.nodes.shape))
    solution = so.Model(lattice, [plane, gravity], engine=engine).solve(np.full(lattice.spring_count, 4.0), [case])
    assert solution.status[0] == "converged"
    depths = np.maximum(-solution.positions[0][:, -1], 0.0)
    assert 200.0 * depths.sum() == pytest.approx(0.05 * lattice.node_count, rel=1e-7)
    assert np.count_nonzero(depths) >= 2


@both
def test_a_body_that_falls_from_high_up_lands(lattice):
    plane = so.PlaneContact(200.0, -2.5 * up(lattice), up(lattice))
    gravity = so.Gravity(-0.05 * up(lattice), mass=1.0)
    case = so.LoadCase("fall", not_adrift(lattice), np.zeros(lattice.nodes.shape))
    solution = so.Model(lattice, [plane, gravity]).solve(np.full(lattice.spring_count, 4.0), [case])
    assert solution.status[0] == "converged"
    depths = np.maximum(-2.5 - solution.positions[0][:, -1], 0.0)
    assert 200.0 * depths.sum() == pytest.approx(0.05 * lattice.node_count, rel=1e-7)


@pytest.mark.parametrize("normal", [(0.0, 1.0), (0.6, 0.8), (1.0, 3.0), (0.1, 0.7)])
def test_a_node_on_the_surface_feels_nothing(normal):
    nodes = np.array([[0.0, 0.0], [1.0, 0.0]]) + 0.1
    lattice = so.SpringLattice(nodes, [[0, 1]])
    plane = so.PlaneContact(100.0, nodes[0] + 0.7 * np.array([-normal[1], normal[0]]), normal, nodes=[0])
    away = np.array(normal) / np.linalg.norm(normal)
    sphere = so.SphereContact(100.0, nodes[0] - 0.3 * away, 0.3, nodes=[0])
    inside = so.SphereContact(100.0, nodes[0] + 0.3 * away, 0.3, inside=True, nodes=[0])
    for effect in (plane, sphere, inside):
        kernel = effect.potential(lattice)
        for answer in probe(kernel, lattice, np.zeros((1, 4)), stiffness=np.ones(1), values=np.array([100.0])).lanes:
            np.testing.assert_array_equal(answer, 0)
        u = np.concatenate([-1e-9 * away, [0.0, 0.0]])[None]
        found = probe(kernel, lattice, u, stiffness=np.ones(1), values=np.array([100.0]))
        np.testing.assert_allclose(found.forces[0, :2], -1e-7 * away, rtol=1e-6, atol=1e-14)


@every_engine
@both
def test_a_body_that_touches_without_load_stays_where_it_is(lattice, engine):
    plane = so.PlaneContact(100.0, np.zeros(lattice.dimension), up(lattice))
    for supports, status in ((so.side(lattice, "left"), "converged"), (not_adrift(lattice), "underdetermined")):
        case = so.LoadCase("rest", supports, np.zeros(lattice.nodes.shape))
        solution = so.Model(lattice, plane, engine=engine).solve(np.full(lattice.spring_count, 4.0), [case])
        assert solution.status[0] == status
        np.testing.assert_array_equal(solution.displacements, 0)


@both
def test_a_body_that_is_pulled_off_leaves(lattice):
    forces = np.where(so.side(lattice, "right")[:, None], 0.1 * up(lattice), 0.0)
    case = so.LoadCase("lift", so.side(lattice, "left"), forces)
    plane = so.PlaneContact(100.0, np.zeros(lattice.dimension), up(lattice))
    stiffness = np.full(lattice.spring_count, 4.0)
    known, found = (so.Model(lattice, effects).solve(stiffness, [case]) for effects in ([], plane))
    np.testing.assert_allclose(found.positions, known.positions, atol=1e-9)


def pushed_in(lattice, stiffness, **options):
    """(the solution, where the tool is) of a ball that is in the way of the middle of the top."""
    middle = np.argmin(
        np.linalg.norm(lattice.nodes - (lattice.nodes.max(axis=0) * [*[0.5] * (len(up(lattice)) - 1), 1]), axis=1)
    )
    center = lattice.nodes[middle] + 0.7 * up(lattice)
    case = so.LoadCase("press", so.side(lattice, "bottom"), np.zeros(lattice.nodes.shape))
    model = so.Model(lattice, so.SphereContact(stiffness, center, 1.0), **options)
    return model.solve(np.full(lattice.spring_count, 4.0), [case]), center


@every_engine
@both
def test_the_push_of_a_ball_is_what_the_supports_hold_up(lattice, engine):
    solution, center = pushed_in(lattice, 50.0, engine=engine)
    assert solution.status[0] == "converged"
    arms = solution.positions[0] - center
    distances = np.linalg.norm(arms, axis=1)
    push = (50.0 * np.maximum(1.0 - distances, 0.0) / distances) @ arms
    ends = solution.positions[0][lattice.springs]
    vectors = ends[:, 1] - ends[:, 0]
    lengths = np.linalg.norm(vectors, axis=1)
    pulls = (4.0 * (lengths - lattice.rest_lengths) / lengths)[:, None] * vectors
    held = so.side(lattice, "bottom")
    reaction = pulls[held[lattice.springs[:, 1]]].sum(axis=0) - pulls[held[lattice.springs[:, 0]]].sum(axis=0)
    assert push[-1] < -0.1
    np.testing.assert_allclose(push, -reaction, atol=1e-7)


@both
def test_penetration_shrinks_as_the_penalty_grows(lattice):
    depths = []
    for stiffness in (1e4, 1e5, 1e6):
        solution, center = pushed_in(lattice, stiffness)
        assert solution.status[0] == "converged"
        depths.append(1.0 - np.linalg.norm(solution.positions[0] - center, axis=1).min())
    assert depths[0] / depths[1] == pytest.approx(10.0, rel=0.02)
    assert depths[1] / depths[2] == pytest.approx(10.0, rel=0.02)


@every_engine
@both
def test_a_node_at_the_center_of_a_ball_gets_out(lattice, engine):
    middle = int(np.argmin(np.linalg.norm(lattice.nodes - lattice.nodes.mean(axis=0) - 0.1, axis=1)))
    ball = so.SphereContact(50.0, lattice.nodes[middle], 0.3)
    case = so.LoadCase("rest", so.side(lattice, "left"), np.zeros(lattice.nodes.shape))
    solution = so.Model(lattice, ball, engine=engine).solve(np.full(lattice.spring_count, 4.0), [case])
    assert solution.status[0] == "converged"
    assert np.linalg.norm(solution.displacements[0, middle]) > 0.1


def test_held_nodes_are_not_in_contact_and_others_may_be_left_out():
    forces = np.where(so.side(GRID, "right")[:, None], [0.1, -0.05], 0.0)
    case = so.LoadCase("pull", so.side(GRID, "left"), forces)
    stiffness = np.full(GRID.spring_count, 4.0)
    everywhere = {"stiffness": 100.0, "point": (0, 9.0), "normal": (0, 1)}
    free = so.Model(GRID).solve(stiffness, [case])
    held = so.Model(GRID, so.PlaneContact(**everywhere, nodes=np.flatnonzero(case.supports[:, 0]))).solve(
        stiffness, [case]
    )
    np.testing.assert_allclose(held.positions, free.positions, atol=1e-9)
    assert held.energy[0] == pytest.approx(free.energy[0], rel=1e-9)


def test_held_nodes_are_not_in_contact_in_motion_either():
    left = so.side(GRID, "left")
    case = so.LoadCase("pull", left, np.where(so.side(GRID, "right")[:, None], [0.1, -0.05], 0.0), times=[0.5, 1.0])
    ground = so.PlaneContact(100.0, point=(0, 9.0), normal=(0, 1), nodes=np.flatnonzero(left))
    energies = [
        so.Model(GRID, [so.Inertia(1.0), *contact], stepping=so.Stepping(0.1))
        .solve(np.full(GRID.spring_count, 4.0), [case])
        .energy
        for contact in ([], [ground])
    ]
    np.testing.assert_allclose(energies[1], energies[0], rtol=1e-9)


@pytest.mark.parametrize(
    ("effect", "message"),
    [
        (so.PlaneContact(1.0, (0, 0), (0, 0)), "normal must point to the free side of the plane, but it is 0"),
        (so.PlaneContact(1.0, (0, 0, 0), (0, 1)), r"point must have the shape \(2,\), not \(3,\)"),
        (so.PlaneContact(-1.0, (0, 0), (0, 1)), "stiffness is -1, but it must be finite and not negative"),
        (so.PlaneContact(1.0, (0, 0), (0, 1), nodes=[77]), r"nodes\[0\] is 77, but the nodes are numbered 0 to 19"),
        (so.PlaneContact(1.0, (0, 0), (0, 1), nodes=[7, 7]), "must each be named once"),
        (so.SphereContact(1.0, (0, 0), 0.0), "radius is 0, but it must be positive"),
        (so.SphereContact(1.0, (0, 0), 1.0, inside=1), "inside must be true or false, not 1"),
    ],
)
def test_options_that_do_not_fit_are_refused(effect, message):
    with pytest.raises(so.UserError, match=message):
        so.Model(GRID, effect)


def test_small_displacements_are_refused():
    with pytest.raises(so.UserError, match="small displacements would leave plane out"):
        so.Model(GRID, so.PlaneContact(1.0, (0, 0), (0, 1)), kinematics="linear")
