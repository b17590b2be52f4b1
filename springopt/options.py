"""The options of a plugin: read off its fields, and set from a scene or the command line."""

from __future__ import annotations

import ast
import inspect
import io
import tokenize
from collections.abc import Mapping
from dataclasses import MISSING, dataclass, fields, is_dataclass
from textwrap import dedent
from typing import Any, TypeVar, get_type_hints

from springopt.errors import PluginError, UserError, did_you_mean
from springopt.optimizer import Optimizer
from springopt.option_types import describe_type, read_option

Plugin = TypeVar("Plugin")


@dataclass(frozen=True)
class Option:
    """One option of an optimizer or of an effect."""

    name: str
    type: Any  #: the field's annotation, resolved
    default: Any  #: `dataclasses.MISSING` where the option must be given
    explanation: str  #: what follows `#:` behind the field, or above it

    @property
    def type_name(self) -> str:
        return describe_type(self.type)

    @property
    def is_required(self) -> bool:
        return self.default is MISSING


def declared_options(plugin: type) -> tuple[Option, ...]:
    """The options of a dataclass in the order of its fields."""
    types = get_type_hints(plugin)
    explanations = _explanations(plugin)
    return tuple(
        Option(field.name, types[field.name], _default(field), explanations.get(field.name, ""))
        for field in fields(plugin)
    )


def options_of(optimizer: type[Optimizer]) -> tuple[Option, ...]:
    """The options of an optimizer, each with its default. Raises PluginError for one that has none."""
    options = declared_options(optimizer)
    for option in options:
        if option.is_required:
            raise PluginError(
                f"option {option.name} of optimizer {optimizer.name} has no default; every option needs one."
            )
    return options


def make_optimizer(optimizer: type[Optimizer], options: Mapping[str, Any] | None = None) -> Optimizer:
    """An optimizer with these options, defaults for the rest; text is read as the option's type asks.

    Raises UserError for an unknown option or a value of another type.
    """
    return make_plugin(optimizer, optimizer.name, options_of(optimizer), options or {})


def make_plugin(plugin: type[Plugin], name: str, declared: tuple[Option, ...], options: Mapping[str, Any]) -> Plugin:
    """The same of any plugin; UserError also where a required option is not given."""
    known = {option.name: option for option in declared}
    values = {}
    for given, value in options.items():
        if given not in known:
            raise UserError(
                f"{name} has no option {given!r}; it has {', '.join(known) or 'none'}.{did_you_mean(given, known)}"
            )
        values[given] = read_option(f"option {given} of {name}", known[given].type, value)
    for option in declared:
        if option.is_required and option.name not in values:
            raise UserError(f"{name} needs its option {option.name}, {option.type_name}; set it.")
    return plugin(**values)


def _default(field: Any) -> Any:
    return field.default if field.default_factory is MISSING else field.default_factory()


def _explanations(plugin: type) -> dict[str, str]:
    explanations: dict[str, str] = {}
    for base in reversed(plugin.__mro__):
        if is_dataclass(base):
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
