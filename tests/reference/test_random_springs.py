"""References drawn at random: their numbers, their springs and their noise."""

import numpy as np
import pytest

from springopt.errors import UserError
from springopt.lattice import SpringLattice, side
from springopt.load_case import LoadCase
from springopt.reference.noise import measured
from springopt.reference.random_springs import pulls, random_stiffness, thin_out
from springopt.reference.words import normals, random_words, uniforms

GRIDS = {"2d": SpringLattice.grid((5, 5)), "3d": SpringLattice.grid((3, 3, 3))}
RIGID = {2: 3, 3: 6}  # motions


def test_words_are_those_of_the_bit_generator_for_ever() -> None:
    assert random_words(2, 0).tolist() == np.random.PCG64([0]).random_raw(2).tolist()
    assert random_words(2, 7, "pull").tolist() == [15304178750167267370, 3123148576182774990]
    assert random_words(2, 7, "push").tolist() != random_words(2, 7, "pull").tolist()


def test_uniform_numbers_keep_off_both_ends() -> None:
    ends = uniforms(np.array([0, 2**64 - 1], dtype=np.uint64))
    assert 0 < ends[0] < 1e-15
    assert 1 - 1e-15 < ends[1] < 1


def test_normal_numbers_have_mean_0_and_deviation_1() -> None:
    numbers = normals(random_words(100_000, 3))
    assert numbers.mean() == pytest.approx(0.0, abs=0.01)
    assert numbers.std() == pytest.approx(1.0, abs=0.01)
    assert np.mean(np.abs(numbers) < 1.96) == pytest.approx(0.95, abs=0.003)


@pytest.mark.parametrize("which", GRIDS)
@pytest.mark.parametrize("seed", [0, 1])
def test_a_share_of_the_springs_is_kept_and_the_body_stays_rigid(which: str, seed: int) -> None:
    lattice = GRIDS[which]
    stiffness = random_stiffness(lattice, seed=seed, stiffness=[2.0, 8.0], kept=0.7)
    present = stiffness > 0
    assert present.sum() == round(0.7 * lattice.spring_count)
    assert ((stiffness[present] > 2.0) & (stiffness[present] < 8.0)).all()
    assert np.linalg.matrix_rank(pulls(lattice)[:, present]) == lattice.nodes.size - RIGID[lattice.dimension]


def test_as_few_springs_as_hold_the_body_can_be_kept_and_no_fewer() -> None:
    lattice = GRIDS["2d"]
    least = lattice.nodes.size - 3
    stiffness = random_stiffness(lattice, seed=2, stiffness=[5.0, 5.0], kept=least / 72)
    assert (np.unique(stiffness).tolist(), np.count_nonzero(stiffness)) == ([0.0, 5.0], least)
    with pytest.raises(UserError, match=r"with fewer than 47 the body is a mechanism; keep a share of 0\.653 or more"):
        random_stiffness(lattice, seed=2, stiffness=[5.0, 5.0], kept=0.5)


def test_what_supports_hold_needs_fewer_springs() -> None:
    lattice = GRIDS["2d"]
    free = ~np.repeat(side(lattice, "left"), 2)
    present = thin_out([pulls(lattice)[free]], range(72), 0)
    assert present.sum() == free.sum()
    assert not present[: np.argmax(present)].any()  # the first are dropped first


def test_a_triangle_can_spare_no_spring_and_of_two_side_by_side_one() -> None:
    triangle = SpringLattice([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], [[0, 1], [1, 2], [2, 0], [0, 1]])
    assert thin_out([pulls(triangle)], [0, 1, 2, 3], 0).tolist() == [False, True, True, True]


def test_other_seeds_draw_other_springs_and_the_same_the_same() -> None:
    first, again, other = (random_stiffness(GRIDS["2d"], seed=s, stiffness=[1.0, 2.0], kept=0.8) for s in (4, 4, 5))
    np.testing.assert_array_equal(first, again)
    assert ((first > 0) != (other > 0)).any()


def test_stiffness_does_not_change_with_the_share_that_is_kept() -> None:
    full, sparse = (random_stiffness(GRIDS["2d"], seed=4, stiffness=[1.0, 2.0], kept=kept) for kept in (1.0, 0.8))
    np.testing.assert_array_equal(sparse[sparse > 0], full[sparse > 0])


def test_anisotropy_makes_springs_along_an_axis_stiffer() -> None:
    lattice = SpringLattice([[0.0, 0.0], [2.0, 0.0], [0.0, 1.0]], [[0, 1], [0, 2], [1, 2]])
    stiffness = random_stiffness(lattice, seed=0, stiffness=[2.0, 2.0], anisotropy=[4.0, 1.0])
    np.testing.assert_allclose(stiffness, [8.0, 2.0, 2 * (4 * 0.8 + 1 * 0.2)])


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"stiffness": [3.0, 2.0]}, "should be a range, its lower end first"),
        ({"stiffness": [0.0, 2.0]}, "stiffness.0. is 0, but it must be positive"),
        ({"stiffness": [2.0]}, r"stiffness must have the shape .2,."),
        ({"stiffness": [1.0, 2.0], "anisotropy": [1.0]}, r"anisotropy must have the shape .2,."),
        ({"stiffness": [1.0, 2.0], "anisotropy": [1.0, -1.0]}, "anisotropy.1. is -1, but it must be positive"),
    ],
)
def test_bad_input_is_refused(options: dict[str, list[float]], sentence: str) -> None:
    with pytest.raises(UserError, match=sentence):
        random_stiffness(GRIDS["2d"], seed=0, **options)  # type: ignore[arg-type]


def test_springs_without_a_direction_and_too_many_springs_are_refused() -> None:
    point = SpringLattice([[0.0, 0.0], [0.0, 0.0]], [[0, 1]])
    with pytest.raises(UserError, match="spring 0 joins two nodes at one place"):
        random_stiffness(point, seed=0, stiffness=[1.0, 2.0], anisotropy=[1.0, 2.0])
    large = SpringLattice.grid((26, 26))
    with pytest.raises(UserError, match="at most 2,000 springs can be thinned out, not 2,550; keep them all"):
        random_stiffness(large, seed=0, stiffness=[1.0, 2.0], kept=0.9)


def test_noise_is_in_free_coordinates_alone_and_each_load_case_has_its_own() -> None:
    lattice = SpringLattice.grid((20, 20))
    held = side(lattice, "left")
    pull, push = (LoadCase(name, held, np.zeros((400, 2))) for name in ("pull", "push"))
    one, same, other = (
        measured(lattice.nodes, case, deviation=0.01, seed=0) - lattice.nodes for case in (pull, pull, push)
    )
    assert not one[held].any()
    assert one[~held].all()
    assert one[~held].std() == pytest.approx(0.01, rel=0.05)
    np.testing.assert_array_equal(one, same)
    assert np.abs(np.corrcoef(one[~held].ravel(), other[~held].ravel())[0, 1]) < 0.1
