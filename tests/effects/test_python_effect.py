"""An effect in plain NumPy does what its compiled twin does, and fails aloud."""

import pickle
from dataclasses import dataclass

import numpy as np
import pytest
from ground_springs import GroundSprings

import springopt as so
from springopt.effects.probe import probe

GRID = so.SpringLattice.grid((5, 4))


@dataclass(frozen=True)
class Ground(so.PythonEffect):
    """Energy stiffness * u^4 / 4 for each degree of freedom."""

    name = "ground"
    is_translation_invariant = False
    is_rotation_invariant = False
    stiffness: float

    def parameters(self, lattice):
        return {"stiffness": np.array([self.stiffness])}

    def pairs(self, lattice):
        return np.arange(lattice.node_count)[:, None].repeat(2, axis=1)

    def evaluate(self, lattice, displacements, *, stiffness, values):
        k = values["stiffness"][:, :, None]
        blocks = 3.0 * (k * displacements**2)[..., None] * np.eye(lattice.dimension)
        return (k * displacements**4).sum(axis=(1, 2)) / 4.0, k * displacements**3, blocks


@dataclass(frozen=True)
class Leashes(so.PythonEffect):
    """The springs once more, of rest length 0 and each 0.3 times as stiff: blocks of two nodes, turned or not."""

    def pairs(self, lattice):
        return lattice.springs[::-1, [0, 0, 1, 1, 1, 0]].reshape(-1, 2)

    def evaluate(self, lattice, displacements, *, stiffness, values):
        k, springs = 0.3 * stiffness[:, ::-1, None], lattice.springs[::-1]
        x = lattice.nodes + displacements
        vectors = x[:, springs[:, 1]] - x[:, springs[:, 0]]
        forces = np.zeros_like(x)
        for lane in range(8):
            np.add.at(forces[lane], springs[:, 1], (k * vectors)[lane])
            np.add.at(forces[lane], springs[:, 0], (-k * vectors)[lane])
        signs = np.array([1.0, 1.0, -1.0])
        blocks = (k * signs)[..., None, None] * np.eye(lattice.dimension)
        d = lattice.dimension
        return 0.5 * (k * vectors**2).sum(axis=(1, 2)), forces, blocks.reshape(8, -1, d, d)


def cases():
    forces = np.random.default_rng(1).normal(0, 0.3, (3, *GRID.nodes.shape))
    held = [so.side(GRID, "left"), np.zeros(GRID.node_count, dtype=bool), so.side(GRID, "top")]
    return [so.LoadCase(str(n), h, f) for n, (h, f) in enumerate(zip(held, forces, strict=True))]


@pytest.mark.parametrize("options", [{}, {"threads": 2}, {"engine": "sparse"}, {"engine": "iterative"}], ids=str)
def test_solves_agree_with_those_of_the_compiled_effect(options):
    candidates = np.random.default_rng(2).uniform(1, 5, (10, GRID.spring_count))
    known = so.Model(GRID, GroundSprings(2.0), **options).solve_many(candidates, cases())
    found = so.Model(GRID, Ground(2.0), **options).solve_many(candidates, cases())
    assert (known.status == "converged").all()
    np.testing.assert_array_equal(found.status, known.status)
    np.testing.assert_allclose(found.positions, known.positions, atol=1e-9)
    np.testing.assert_allclose(found.energy, known.energy, rtol=1e-11)


def test_a_fitted_parameter_reaches_it():
    stiffness = np.full(GRID.spring_count, 3.0)
    parameters = so.Parameters(stiffness, {"ground.stiffness": 7.0})
    found = so.Model(GRID, Ground(2.0)).solve(parameters, cases()[:1])
    known = so.Model(GRID, GroundSprings(7.0)).solve(stiffness, cases()[:1])
    np.testing.assert_allclose(found.positions, known.positions, atol=1e-9)


@pytest.mark.parametrize("engine", ["lanes", "sparse", "iterative"])
def test_blocks_of_two_nodes_go_where_they_belong(engine):
    stiffness = np.random.default_rng(3).uniform(1, 5, GRID.spring_count)
    twice = so.SpringLattice(
        GRID.nodes, np.tile(GRID.springs, (2, 1)), np.concatenate([GRID.rest_lengths, 0.0 * GRID.rest_lengths])
    )
    held = cases()[::2]
    known = so.Model(twice, engine=engine).solve(np.concatenate([stiffness, 0.3 * stiffness]), held)
    found = so.Model(GRID, Leashes(), engine=engine).solve(stiffness, held)
    assert (known.status == "converged").all()
    np.testing.assert_array_equal(found.status, known.status)
    np.testing.assert_allclose(found.positions, known.positions, atol=1e-8)
    assert np.abs(found.batch.iterations - known.batch.iterations).max() <= 1  # the same tangents, the same way


@dataclass(frozen=True)
class Broken(Ground):
    """Fails where it is pulled too far."""

    limit: float = 0.01

    def evaluate(self, lattice, displacements, *, stiffness, values):
        if np.abs(displacements).max() > self.limit:
            raise ZeroDivisionError("pulled too far")
        return super().evaluate(lattice, displacements, stiffness=stiffness, values=values)


@pytest.mark.parametrize(
    "options",
    [{}, {"threads": 2}, {"engine": "sparse"}, {"engine": "iterative"}, {"branch": "followed"}],
    ids=str,
)
def test_an_error_inside_is_raised_by_the_solve_and_by_the_next_one_again(options):
    model = so.Model(GRID, Broken(2.0), **options)
    for _ in range(2):
        with pytest.raises(ZeroDivisionError, match="pulled too far"):
            model.solve_many(np.full((10, GRID.spring_count), 3.0), cases())


def test_an_error_at_once_is_raised_as_well():
    model = so.Model(GRID, Broken(2.0, limit=-1.0))
    with pytest.raises(ZeroDivisionError, match="pulled too far"):
        model.solve(np.full(GRID.spring_count, 3.0), cases())
    kernel = Broken(2.0, limit=-1.0).potential(GRID)
    with pytest.raises(ZeroDivisionError, match="pulled too far"):
        probe(kernel, GRID, np.zeros((1, GRID.nodes.size)), stiffness=np.ones(GRID.spring_count), values=np.ones(1))


@dataclass(frozen=True)
class Misshapen(Ground):
    def evaluate(self, lattice, displacements, *, stiffness, values):
        energy, forces, blocks = super().evaluate(lattice, displacements, stiffness=stiffness, values=values)
        return energy, forces[:, :, 0], blocks


def test_arrays_of_another_shape_are_named():
    with pytest.raises(
        ValueError, match=r"evaluate of Misshapen must give forces of shape \(8, 20, 2\), not \(8, 20\)"
    ):
        so.Model(GRID, Misshapen(2.0)).solve(np.full(GRID.spring_count, 3.0), cases())


def test_a_kernel_survives_being_sent_away():
    kernel = pickle.loads(pickle.dumps(Ground(2.0).potential(GRID)))
    found = probe(kernel, GRID, np.ones((1, 40)), stiffness=np.ones(GRID.spring_count), values=np.array([2.0]))
    assert found.energy[0] == pytest.approx(20.0)


def test_an_objective_is_sent_away_without_addresses_of_kernels():
    """They mean nothing in another process, and calling them would end it."""
    stiffness = np.full(GRID.spring_count, 3.0)
    positions = so.Model(GRID).solve(stiffness, cases()).positions
    goal = so.Objective(so.Model(GRID, Ground(2.0)), cases(), positions)
    value = goal.evaluate(stiffness[None]).values
    copy = pickle.loads(pickle.dumps(goal))
    assert "_groups" not in vars(copy)
    assert copy.evaluate(stiffness[None]).values == value


def test_a_solution_is_sent_away_without_addresses_of_kernels():
    loose = so.SpringLattice([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]], [[0, 1]])
    case = so.LoadCase("rest", [True, False, False], np.zeros((3, 2)))
    solution = so.Model(loose, Ground(0.0)).solve([1.0], [case])
    copy = pickle.loads(pickle.dumps(solution))
    assert len(copy.zero_modes[0]) == len(solution.zero_modes[0]) == 3
    assert not hasattr(copy, "groups")
