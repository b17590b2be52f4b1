"""Zero modes at rest, counted by pivots, against the rank of the lattice's compatibility matrix."""

import numpy as np
import pytest

import springopt as so
from springopt.forward.rest_modes import zero_mode_counts, zero_mode_shares


def compatibility_rank(lattice, exists, free):
    rows = []
    for (i, j), present in zip(lattice.springs, exists, strict=True):
        vector = lattice.nodes[j] - lattice.nodes[i]
        directions = [vector / np.linalg.norm(vector)] if vector.any() else list(np.eye(lattice.dimension))
        for direction in directions if present else []:
            row = np.zeros(lattice.nodes.shape)
            row[j], row[i] = direction, -direction
            rows.append(row.ravel())
    return np.linalg.matrix_rank(np.array(rows)[:, free], tol=1e-9) if rows else 0


@pytest.mark.parametrize("engine", ["lanes", "sparse"])
@pytest.mark.parametrize("shape", [(4, 3), (3, 2, 2)])
@pytest.mark.parametrize("density", [0.0, 0.3, 0.5, 0.8, 1.0])
def test_zero_pivots_are_as_many_as_the_rank_lacks(engine, shape, density):
    grid = so.SpringLattice.grid(shape)
    nodes = np.vstack([grid.nodes, grid.nodes[-1:]])  # the last node doubled, tied by a spring of rest length 0
    springs = np.vstack([grid.springs, [[grid.node_count - 1, grid.node_count]]])
    lattice = so.SpringLattice(nodes, springs)
    supports = np.zeros(nodes.shape, dtype=bool)
    supports[so.side(lattice, "left"), 0] = True  # rollers, so that there are partly free nodes
    supports[0] = True
    case = so.LoadCase("none", supports, np.zeros(nodes.shape))
    (group,) = so.Model(lattice, engine=engine).groups([case])
    exists = np.random.default_rng(7).random((9, lattice.spring_count)) < density
    free = np.flatnonzero(~supports.ravel())
    known = [len(free) - compatibility_rank(lattice, candidate, free) for candidate in exists]
    np.testing.assert_array_equal(zero_mode_counts(group, exists), known)


def test_a_load_case_with_an_equilibrium_counts_as_none():
    lattice = so.SpringLattice([[0, 0], [1, 0], [0, 1], [5, 5]], [[0, 1], [0, 2], [1, 2]])
    held = [True, True, False, False]
    cases = [so.LoadCase("a", held, [[0, 0], [0, 0], [0.1, 0], [0, 0]]), so.LoadCase("b", held, np.full((4, 2), 0.1))]
    model = so.Model(lattice)
    batch = model.solve_many(np.ones((1, 3)), cases)
    assert [str(status) for status in batch.status[0]] == ["underdetermined", "mechanism"]
    shares = zero_mode_shares(model.groups(cases), np.ones((1, 3)), batch.equilibria.codes)
    assert shares[0] == pytest.approx(0.5 * 2 / 4)
