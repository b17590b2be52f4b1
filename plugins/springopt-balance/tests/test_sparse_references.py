"""The benchmark of sparse references, on few of them."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import norm

from springopt.reference.random_springs import pulls

SCENE = "paper-stiffness-2d"


@pytest.fixture(scope="module")
def sparse():
    path = Path(__file__).parents[3] / "benchmarks" / "sparse_references.py"
    spec = importlib.util.spec_from_file_location("sparse_references", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_a_reference_keeps_its_share_and_stands_on_every_set_of_supports(sparse):
    reference = sparse.make_reference(SCENE, 0)
    assert 0.65 <= reference.present.mean() <= 0.9
    matrix = pulls(reference.model.lattice)[:, reference.present]
    for case in reference.cases:
        free = case.free.ravel()
        assert np.linalg.matrix_rank(matrix[free]) == np.count_nonzero(free)
    moves = np.linalg.norm(reference.positions - reference.model.lattice.nodes, axis=2)
    assert moves.max() <= 0.5


def test_springs_are_told_apart_without_noise_and_with_little(sparse):
    reference = sparse.make_reference(SCENE, 0)
    for noise in (0.0, 1e-4):
        balanced, refined, bound, _ = sparse.score(reference, SCENE, noise, 0)
        assert (balanced, refined, bound) == (1.0, 1.0, 1.0)


def test_a_flip_is_its_own_inverse_and_tells_mean_and_error(sparse):
    rng = np.random.default_rng(0)
    root = rng.normal(size=(7, 4))
    matrix, pull = root.T @ root, rng.normal(size=4)
    whole = np.block([[matrix, pull[:, None]], [pull, np.zeros(1)]])
    tableau, present = whole.copy(), np.zeros(4, dtype=bool)
    for spring in range(4):
        sparse.flip(tableau, present, spring)
    np.testing.assert_allclose(tableau[:4, -1], np.linalg.solve(matrix, pull))
    np.testing.assert_allclose(tableau.diagonal()[:4], np.linalg.inv(matrix).diagonal())
    for spring in range(4):
        sparse.flip(tableau, present, spring)
    np.testing.assert_allclose(tableau, whole, atol=1e-12)


@pytest.mark.parametrize(("mean", "error"), [(1.0, 0.4), (5.0, 0.1), (0.1, 0.3), (-2.0, 0.5), (9.5, 1.0), (4.0, 50.0)])
def test_the_probability_is_that_of_bayes_rule(sparse, mean, error):
    present = 0.7 / 6.0 * (norm.cdf(8.0, mean, error) - norm.cdf(2.0, mean, error))
    absent = 0.3 * norm.pdf(0.0, mean, error)
    assert sparse.probability(mean, error, 0.7) == pytest.approx(present / (present + absent), rel=1e-9)
