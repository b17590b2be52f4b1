import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from springopt.errors import UserError
from springopt.load_case import LoadCase

NAN = np.nan
HELD = np.array([True, False, False])
FORCES = np.zeros((3, 2))


def case(**changes):
    return LoadCase(**({"name": "pull", "supports": HELD, "forces": FORCES} | changes))


def test_a_held_node_is_held_along_every_axis():
    assert case().supports.tolist() == [[True, True], [False, False], [False, False]]
    np.testing.assert_array_equal(case().free, ~case().supports)


def test_supports_can_differ_by_axis():
    supports = np.array([[True, False], [False, False], [False, True]])
    np.testing.assert_array_equal(case(supports=supports).supports, supports)


def test_nothing_is_prescribed_unless_said():
    assert case().prescribed.tolist() == FORCES.tolist()


def test_a_prescribed_displacement_becomes_a_support_where_nan_leaves_the_rest_free():
    moved = case(prescribed=[[NAN, NAN], [NAN, 0.5], [0.0, NAN]])
    assert moved.supports.tolist() == [[True, True], [False, True], [True, False]]
    assert moved.prescribed.tolist() == [[0.0, 0.0], [0.0, 0.5], [0.0, 0.0]]


def test_displacements_without_nan_are_those_of_the_supports():
    moved = case(prescribed=[[0.1, 0.2], [0.0, 0.0], [0.0, 0.0]])
    assert moved.supports.tolist() == case().supports.tolist()
    assert moved.prescribed[0].tolist() == [0.1, 0.2]


@given(arrays(np.float64, (3, 2), elements=st.sampled_from([NAN, 0.0, -0.5, 2.0])))
def test_only_supports_are_moved(prescribed):
    if not np.isnan(prescribed).any():
        prescribed[0, 0] = NAN
    moved = case(prescribed=prescribed)
    assert np.all(moved.prescribed[moved.free] == 0)
    np.testing.assert_array_equal(moved.supports, case().supports | ~np.isnan(prescribed))


def test_a_force_on_a_support_is_legal():
    assert case(forces=[[1.0, 0.0], [0.0, 0.0], [0.0, 0.0]]).forces[0, 0] == 1.0


def test_no_support_at_all_is_legal():
    assert case(supports=np.zeros(3, bool)).free.all()


def test_a_load_case_keeps_its_own_copy():
    forces = FORCES.copy()
    mine = case(forces=forces)
    forces[0] = 1.0
    assert not mine.forces.any()


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"forces": [[0.0, 0.0], [NAN, 0.0], [0.0, 0.0]]}, r"load case 'pull': forces\[1, 0\] is nan"),
        ({"forces": [[0.0, 0.0], [0.0, np.inf], [0.0, 0.0]]}, r"load case 'pull': forces\[1, 1\] is inf"),
        ({"forces": np.zeros(3)}, r"load case 'pull': forces must have the shape \(n, d\)"),
        ({"supports": [0]}, "load case 'pull': supports must hold booleans"),
        ({"supports": [True, False]}, r"must have the shape \(3, 2\), not \(2, 2\)"),
        ({"prescribed": np.zeros((2, 2))}, r"load case 'pull': prescribed must have the shape \(3, 2\)"),
        ({"prescribed": np.full((3, 2), np.inf)}, r"load case 'pull': prescribed\[0, 0\] is inf"),
        ({"prescribed": [[0.0, 0.0], [0.0, 0.5], [0.0, 0.0]]}, r"\[1, 1\] is 0.5, but nothing holds it there"),
        ({"role": "training"}, "must be 'train' or 'test', not 'training'"),
    ],
)
def test_an_impossible_load_case_is_refused_naming_the_entry(changes, sentence):
    with pytest.raises(UserError, match=sentence):
        case(**changes)


@pytest.mark.parametrize("times", [[], [0.0, 1.0], [1.0, 1.0], [2.0, 1.0], [[1.0]], [NAN]])
def test_times_ascend_from_above_zero(times):
    with pytest.raises(UserError, match="times"):
        case(times=times)


def test_a_load_case_with_times_keeps_them():
    assert case(times=[0.5, 1.0]).times.tolist() == [0.5, 1.0]
    assert case().times is None
