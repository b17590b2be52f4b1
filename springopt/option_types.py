"""The types that an option may have: bool, int, float, str, a choice of words, a tuple, each or None."""

from __future__ import annotations

import math
from collections.abc import Callable
from types import NoneType, UnionType
from typing import Any, Literal, Union, get_args, get_origin

from springopt.errors import PluginError, UserError

_NAMES = {bool: "true or false", int: "a whole number", float: "a number", str: "text", NoneType: "none"}


def describe_type(annotation: Any) -> str:
    """The type in the user's words: "a whole number", "'cut' or 'clip'"."""
    if annotation in _NAMES:
        return _NAMES[annotation]
    if get_origin(annotation) is Literal:
        return " or ".join(repr(choice) for choice in get_args(annotation))
    if get_origin(annotation) in (Union, UnionType):
        return " or ".join(describe_type(member) for member in get_args(annotation))
    if get_origin(annotation) is tuple:
        return f"a list, each {describe_type(_item(annotation))}"
    raise PluginError(f"an option can't have the type {annotation}; use bool, int, float, str, Literal or a tuple.")


def read_option(name: str, annotation: Any, value: Any) -> Any:
    """A value of the annotated type; text is parsed, as it comes from a command line. Raises UserError."""
    try:
        return _read(annotation, value)
    except ValueError:
        raise UserError(f"{name} is {describe_type(annotation)}, not {value!r}; give another value.") from None


def _read(annotation: Any, value: Any) -> Any:
    if annotation in _READERS:
        return _READERS[annotation](value)
    origin = get_origin(annotation)
    if origin is Literal:
        return _first(get_args(annotation), lambda choice: _choice(choice, value))
    if origin in (Union, UnionType):
        # Text fits anything: the other members get the first try.
        members = sorted(get_args(annotation), key=lambda member: member is str)
        return _first(members, lambda member: _read(member, value))
    if origin is tuple:
        items = value.split(",") if isinstance(value, str) else value
        return tuple(_read(_item(annotation), item) for item in _require(items, isinstance(items, list | tuple)))
    describe_type(annotation)  # refuses the type
    raise ValueError


def _item(annotation: Any) -> Any:
    item, *rest = get_args(annotation)
    if rest != [...]:
        raise PluginError(f"an option can't have the type {annotation}; write tuple[T, ...].")
    return item


def _first(candidates: tuple[Any, ...] | list[Any], read: Callable[[Any], Any]) -> Any:
    for candidate in candidates:
        try:
            return read(candidate)
        except ValueError:
            continue
    raise ValueError


def _choice(choice: Any, value: Any) -> Any:
    return _require(choice, (type(value) is type(choice) and value == choice) or value == str(choice))


def _require(value: Any, legal: bool) -> Any:
    if not legal:
        raise ValueError
    return value


def _bool(value: Any) -> bool:
    if isinstance(value, str):
        return _require(value.lower() == "true", value.lower() in ("true", "false"))
    return _require(value, isinstance(value, bool))


def _int(value: Any) -> int:
    if isinstance(value, str):
        return int(value)
    return _require(value, isinstance(value, int) and not isinstance(value, bool))


def _float(value: Any) -> float:
    number = float(_require(value, isinstance(value, str | int | float) and not isinstance(value, bool)))
    return _require(number, math.isfinite(number))


def _str(value: Any) -> str:
    return _require(value, isinstance(value, str))


def _none(value: Any) -> None:
    return _require(None, value is None or value == "none")


_READERS: dict[Any, Callable[[Any], Any]] = {bool: _bool, int: _int, float: _float, str: _str, NoneType: _none}
