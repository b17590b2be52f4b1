"""Band and sparse factors against dense linear algebra."""

import numpy as np
import pytest

import springopt as so
from springopt.forward.band import Band
from springopt.forward.dissection import dissect


def random_band(size, width, shift, seed=0):
    matrix = np.tril(np.random.default_rng(seed).uniform(-1, 1, (size, size)))
    matrix[np.subtract.outer(np.arange(size), np.arange(size)) > width] = 0
    return matrix + np.tril(matrix, -1).T + shift * np.eye(size)


def band_of(matrix, width, kind=np.float64):
    band = Band.empty(len(matrix), width, kind)
    band.clear()
    rows, columns = np.nonzero(np.tril(matrix))
    band.entries[columns * band.stride + rows] = matrix[rows, columns]
    return band


@pytest.mark.parametrize(("kind", "within"), [(np.float64, 1e-13), (np.float32, 2e-5)])
@pytest.mark.parametrize(("size", "width"), [(1, 0), (5, 2), (16, 15), (17, 3), (40, 39), (133, 50), (300, 111)])
def test_a_factor_solves_its_system(size, width, kind, within):
    matrix = random_band(size, width, shift=width + 2.0)
    band = band_of(matrix, width, kind)
    band.factorize(1e-2)
    sides = np.random.default_rng(1).normal(size=(size, 8))
    np.testing.assert_allclose(band.solve(sides), np.linalg.solve(matrix, sides), atol=within)
    np.testing.assert_array_equal(band.solve(sides[:, 2:3])[:, 0], band.solve(sides)[:, 2])
    assert tuple(band.inertia[:3]) == (0, 0, -1)


def test_a_band_can_be_filled_again():
    band = band_of(random_band(70, 9, shift=11.0, seed=3), 9)
    band.factorize(1e-2)
    band.clear()
    again = random_band(70, 9, shift=12.0, seed=4)
    rows, columns = np.nonzero(np.tril(again))
    band.entries[columns * band.stride + rows] = again[rows, columns]
    band.factorize(1e-2)
    sides = np.ones((70, 1))
    np.testing.assert_allclose(band.solve(sides), np.linalg.solve(again, sides), atol=1e-13)


@pytest.mark.parametrize("shift", np.linspace(0.0, 9.0, 13))
def test_negative_pivots_are_found_exactly_where_a_matrix_curves_down(shift):
    matrix = random_band(60, 12, shift)
    band = band_of(matrix, 12)
    band.factorize(1e-2)
    is_indefinite = np.linalg.eigvalsh(matrix)[0] < 0
    assert (band.inertia[0] > 0) == is_indefinite
    if is_indefinite:
        y = band.negative_direction()
        assert y @ matrix @ y < 0


def test_zero_pivots_are_counted():
    matrix = random_band(30, 5, shift=7.0)
    matrix[[4, 20]] = 0
    matrix[:, [4, 20]] = 0
    band = band_of(matrix, 5)
    band.factorize(1e-2)
    assert tuple(band.inertia[:2]) == (0, 2)


@pytest.mark.parametrize("shape", [(40, 40), (12, 12, 12)])
def test_nested_dissection_orders_every_node_once_and_keeps_factors_sparse(shape):
    from scipy.sparse import coo_array
    from scipy.sparse.linalg import splu

    lattice = so.SpringLattice.grid(shape)
    order = dissect(lattice.nodes, lattice.springs)
    np.testing.assert_array_equal(np.sort(order), np.arange(lattice.node_count))

    def fill(order):
        place = np.argsort(order)
        i, j = place[lattice.springs].T
        n = lattice.node_count
        half = coo_array((np.full(len(i), -1.0), (i, j)), shape=(n, n)).tocsc()
        matrix = (half + half.T).tolil()
        matrix.setdiag(30.0)
        factor = splu(matrix.tocsc(), permc_spec="NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
        return factor.L.nnz

    assert fill(order) < 0.75 * fill(np.arange(lattice.node_count))
