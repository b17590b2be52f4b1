"""The types that an option may have: bool, int, float, str, a choice of words, a list, a table, each or None."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from types import NoneType, UnionType
from typing import Any, Literal, Union, get_args, get_origin

from springopt.errors import PluginError, UserError

Reader = Callable[[Any], Any]

_LISTS = (tuple, Sequence)
_NAMES = {bool: "true or false", int: "a whole number", float: "a number", str: "text", NoneType: "none"}


def describe_type(annotation: Any) -> str:
    """The type in the user's words: "a whole number", "'cut' or 'clip'"."""
    if annotation in _NAMES:
        return _NAMES[annotation]
    if get_origin(annotation) is Literal:
        return " or ".join(repr(choice) for choice in get_args(annotation))
    if get_origin(annotation) in (Union, UnionType):
        return " or ".join(describe_type(member) for member in get_args(annotation))
    if get_origin(annotation) is Mapping and get_args(annotation)[0] is str:
        return f"a table, each {describe_type(get_args(annotation)[1])}"
    if get_origin(annotation) in _LISTS:
        return f"a list, each {describe_type(_item(annotation))}"
    raise PluginError(
        f"an option can't have the type {annotation}; use bool, int, float, str, Literal, a tuple or a Mapping."
    )


def read_option(name: str, annotation: Any, value: Any) -> Any:
    """A value of the annotated type; text is parsed, as it comes from a command line. Raises UserError."""
    try:
        return _read(annotation, value, _TEXT_READERS)
    except ValueError:
        raise UserError(f"{name} is {describe_type(annotation)}, not {value!r}; give another value.") from None


def read_exactly(annotation: Any, value: Any) -> Any:
    """A value of the annotated type, with tuples for lists and floats for whole numbers. Raises ValueError."""
    return _read(annotation, value, _READERS)


def _read(annotation: Any, value: Any, readers: Mapping[Any, Reader]) -> Any:
    if annotation in readers:
        return readers[annotation](value)
    origin = get_origin(annotation)
    if origin is Literal:
        return _first(get_args(annotation), lambda choice: readers[Literal]((choice, value)))
    if origin in (Union, UnionType):
        # Text fits anything: the other members get the first try.
        members = sorted(get_args(annotation), key=lambda member: member is str)
        return _first(members, lambda member: _read(member, value, readers))
    if origin in _LISTS:
        items = readers[list](value)
        return tuple(_read(_item(annotation), item, readers) for item in items)
    if origin is Mapping:
        return {key: _read(get_args(annotation)[1], item, readers) for key, item in readers[dict](value).items()}
    describe_type(annotation)  # refuses the type
    raise ValueError


def _item(annotation: Any) -> Any:
    item, *rest = get_args(annotation)
    if get_origin(annotation) is tuple and rest != [...]:
        raise PluginError(f"an option can't have the type {annotation}; write tuple[T, ...].")
    return item


def _first(candidates: Sequence[Any], read: Reader) -> Any:
    for candidate in candidates:
        try:
            return read(candidate)
        except ValueError:
            continue
    raise ValueError


def _require(value: Any, legal: bool) -> Any:
    if not legal:
        raise ValueError
    return value


def _choice(pair: tuple[Any, Any]) -> Any:
    choice, value = pair
    return _require(choice, type(value) is type(choice) and value == choice)


def _float(value: Any) -> float:
    number = float(_require(value, isinstance(value, int | float) and not isinstance(value, bool)))
    return _require(number, math.isfinite(number))


_READERS: dict[Any, Reader] = {
    bool: lambda value: _require(value, isinstance(value, bool)),
    int: lambda value: _require(value, isinstance(value, int) and not isinstance(value, bool)),
    float: _float,
    str: lambda value: _require(value, isinstance(value, str)),
    NoneType: lambda value: _require(None, value is None),
    list: lambda value: _require(value, isinstance(value, list | tuple)),
    dict: lambda value: _require(value, isinstance(value, Mapping)),
    Literal: _choice,
}


def _or_text(kind: Any, parse: Reader) -> Reader:
    """Reads text by parsing it, and all else exactly."""
    return lambda value: parse(value) if isinstance(value, str) else _READERS[kind](value)


def _pair(text: str) -> tuple[str, str]:
    """key:value, as in "straight:1.1"."""
    key, colon, value = text.rpartition(":")
    return _require((key, value), bool(colon))


_TEXT_READERS: dict[Any, Reader] = {
    bool: _or_text(bool, lambda text: _require(text.lower() == "true", text.lower() in ("true", "false"))),
    int: _or_text(int, int),
    float: _or_text(float, lambda text: _float(float(text))),
    str: _READERS[str],
    NoneType: _or_text(NoneType, lambda text: _require(None, text == "none")),
    list: _or_text(list, lambda text: text.split(",")),
    dict: _or_text(dict, lambda text: dict(_pair(item) for item in text.split(","))),
    Literal: lambda pair: pair[0] if pair[1] == str(pair[0]) else _choice(pair),
}
