import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from springopt import checks
from springopt.errors import UserError, did_you_mean


def test_every_check_returns_its_array():
    array = np.array([1.0, 2.0])
    assert checks.require_shape("a", array, ("s",)) is array
    for check in (checks.require_finite, checks.require_positive, checks.require_nonnegative):
        assert check("a", array) is array


@given(place=st.integers(0, 4), value=st.sampled_from([np.nan, np.inf, -np.inf]))
def test_a_number_that_is_not_finite_is_named_with_its_place(place, value):
    array = np.ones(5)
    array[place] = value
    for check in (checks.require_finite, checks.require_positive, checks.require_nonnegative):
        with pytest.raises(UserError, match=rf"stiffness\[{place}\] is {value:g}"):
            check("stiffness", array)


def test_zero_is_not_negative_but_not_positive_either():
    checks.require_nonnegative("young", 0.0)
    with pytest.raises(UserError, match="young is 0, but it must be positive"):
        checks.require_positive("young", 0.0)


def test_the_first_offending_entry_of_a_table_is_named():
    with pytest.raises(UserError, match=r"forces\[1, 0\] is nan"):
        checks.require_finite("forces", np.array([[0.0, 1.0], [np.nan, np.nan]]))


@pytest.mark.parametrize("shape", [(3,), (2, 2), (2, 3, 1)])
def test_another_shape_is_refused_in_words(shape):
    with pytest.raises(UserError, match=r"forces must have the shape \(n, 3\)"):
        checks.require_shape("forces", np.zeros(shape), ("n", 3))


def test_none_and_letters_stand_for_any_length():
    checks.require_shape("a", np.zeros((4, 2)), (None, 2))
    checks.require_shape("a", np.zeros((4, 2)), ("n", "d"))


@pytest.mark.parametrize("values", ["abc", [1.0, None], [1j], [[1.0], [1.0, 2.0]], [True, False]])
def test_floats_refuses_what_is_not_a_real_number(values):
    with pytest.raises(UserError, match="positions must"):
        checks.floats("positions", values)


def test_integers_refuses_whole_floats_and_booleans_refuses_node_numbers():
    with pytest.raises(UserError, match="springs must hold integers, not float64"):
        checks.integers("springs", [0.0, 1.0])
    with pytest.raises(UserError, match="supports must hold booleans"):
        checks.booleans("supports", [0, 1])


def test_conversions_copy_so_that_the_callers_array_can_change():
    mine = np.zeros(2)
    theirs = checks.floats("mine", mine)
    mine[0] = 1.0
    assert theirs[0] == 0.0


def test_a_typing_error_gets_a_hint_and_a_stranger_none():
    assert did_you_mean("moor", ["moore", "von-neumann"]) == " Did you mean 'moore'?"
    assert did_you_mean("xyz", ["moore", "von-neumann"]) == ""
