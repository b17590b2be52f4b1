"""Checks of arrays at the public door: each returns the array, or raises a UserError that names the entry."""

from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from springopt.errors import UserError

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Booleans = NDArray[np.bool_]
A = TypeVar("A", bound=NDArray[Any])
Numbers = TypeVar("Numbers", bound=NDArray[Any] | float)


def floats(name: str, values: ArrayLike) -> Floats:
    """A copy of the values as floats; text, objects, complex and ragged lists are refused."""
    array = _array(name, values)
    if array.dtype.kind not in "fiu":
        raise UserError(f"{name} must hold real numbers, not {array.dtype}.")
    return array.astype(np.float64)


def integers(name: str, values: ArrayLike) -> Integers:
    """A copy of the values as integers; floats are refused, even whole ones."""
    array = _array(name, values)
    if array.size and array.dtype.kind not in "iu":
        raise UserError(f"{name} must hold integers, not {array.dtype}.")
    return array.astype(np.int64)


def booleans(name: str, values: ArrayLike) -> Booleans:
    """A copy of the values as booleans; node numbers are refused, because they would read as True."""
    array = _array(name, values)
    if array.dtype.kind != "b":
        raise UserError(f"{name} must hold booleans, one for each node or degree of freedom, not {array.dtype}.")
    return array.copy()


def require_shape(name: str, array: A, shape: tuple[int | str | None, ...]) -> A:
    """Refuses another shape; a letter or None in `shape` stands for any length."""
    fits = len(shape) == array.ndim and all(
        not isinstance(want, int) or want == have for want, have in zip(shape, array.shape, strict=True)
    )
    if not fits:
        wanted = ", ".join("any" if want is None else str(want) for want in shape)
        comma = "," if len(shape) == 1 else ""
        raise UserError(f"{name} must have the shape ({wanted}{comma}), not {array.shape}.")
    return array


def require_finite(name: str, array: Numbers) -> Numbers:
    """Refuses nan and infinity."""
    return _require(name, array, np.isfinite(array), "must be finite")


def require_positive(name: str, array: Numbers) -> Numbers:
    """Refuses nan, infinity, zero and negative numbers."""
    return _require(name, array, np.greater(array, 0) & np.isfinite(array), "must be positive and finite")


def require_nonnegative(name: str, array: Numbers) -> Numbers:
    """Refuses nan, infinity and negative numbers."""
    return _require(name, array, np.greater_equal(array, 0) & np.isfinite(array), "must be finite and not negative")


def _require(name: str, array: Numbers, passes: Booleans, rule: str) -> Numbers:
    if not np.all(passes):
        entry = np.argwhere(~np.asarray(passes))[0]
        where = f"[{', '.join(map(str, entry))}]" if entry.size else ""
        raise UserError(f"{name}{where} is {np.asarray(array)[tuple(entry)]:g}, but it {rule}.")
    return array


def _array(name: str, values: ArrayLike) -> NDArray[Any]:
    try:
        return np.asarray(values)
    except ValueError:
        raise UserError(f"{name} must be an array; its rows have different lengths.") from None
