"""The options of an optimizer: read off its fields, and set from a scene or the command line."""

from __future__ import annotations

import ast
import inspect
import io
import tokenize
from collections.abc import Mapping
from dataclasses import MISSING, dataclass, fields
from textwrap import dedent
from typing import Any, get_type_hints

from springopt.errors import PluginError, UserError, did_you_mean
from springopt.optimizer import Optimizer
from springopt.option_types import describe_type, read_option


@dataclass(frozen=True)
class Option:
    """One option of an optimizer."""

    name: str
    type: Any  #: the field's annotation, resolved
    default: Any
    explanation: str  #: what follows `#:` behind the field, or above it

    @property
    def type_name(self) -> str:
        return describe_type(self.type)


def options_of(optimizer: type[Optimizer]) -> tuple[Option, ...]:
    """The options of an optimizer in the order of its fields."""
    types = get_type_hints(optimizer)
    explanations = _explanations(optimizer)
    return tuple(
        Option(field.name, types[field.name], _default(optimizer, field), explanations.get(field.name, ""))
        for field in fields(optimizer)
    )


def make_optimizer(optimizer: type[Optimizer], options: Mapping[str, Any] | None = None) -> Optimizer:
    """An optimizer with these options, defaults for the rest; text is read as the option's type asks.

    Raises UserError for an unknown option or a value of another type.
    """
    known = {option.name: option for option in options_of(optimizer)}
    values = {}
    for name, value in (options or {}).items():
        if name not in known:
            raise UserError(
                f"{optimizer.name} has no option {name!r}; it has {', '.join(known) or 'none'}."
                f"{did_you_mean(name, known)}"
            )
        values[name] = read_option(f"option {name} of {optimizer.name}", known[name].type, value)
    return optimizer(**values)


def _default(optimizer: type[Optimizer], field: Any) -> Any:
    if field.default is not MISSING:
        return field.default
    if field.default_factory is not MISSING:
        return field.default_factory()
    raise PluginError(f"option {field.name} of optimizer {optimizer.name} has no default; every option needs one.")


def _explanations(optimizer: type[Optimizer]) -> dict[str, str]:
    explanations: dict[str, str] = {}
    for base in reversed(optimizer.__mro__):
        if issubclass(base, Optimizer):
            explanations |= _explanations_in(base)
    return explanations


def _explanations_in(cls: type) -> dict[str, str]:
    """What the source of a class says of its fields; nothing where there is no source, as in a notebook's `exec`."""
    try:
        source = dedent(inspect.getsource(cls))
    except (OSError, TypeError):
        return {}
    behind, alone = _marked_comments(source)
    body = ast.parse(source).body[0].body  # type: ignore[attr-defined]
    return {
        statement.target.id: behind.get(statement.end_lineno or 0) or _above(statement.lineno, alone)
        for statement in body
        if isinstance(statement, ast.AnnAssign) and isinstance(statement.target, ast.Name)
    }


def _marked_comments(source: str) -> tuple[dict[int, str], dict[int, str]]:
    """The text of each `#:` comment by its line: those behind code, and those alone on their line."""
    behind: dict[int, str] = {}
    alone: dict[int, str] = {}
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type == tokenize.COMMENT and token.string.startswith("#:"):
            place = alone if token.line.lstrip().startswith("#:") else behind
            place[token.start[0]] = token.string[2:].strip()
    return behind, alone


def _above(line: int, comments: dict[int, str]) -> str:
    """The block of comments that ends above a line."""
    block = []
    while (line := line - 1) in comments:
        block.append(comments[line])
    return " ".join(reversed(block))
