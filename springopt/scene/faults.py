"""pydantic's findings in the words of someone who wrote a scene."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any, Literal, get_args, get_origin

from pydantic import ValidationError

from springopt.errors import SceneError, did_you_mean
from springopt.scene.table import Table

Location = tuple[int | str, ...]


def scene_error(source: str, faults: Iterable[str]) -> SceneError:
    """All faults of a scene as one error."""
    sentences = [fault if fault.endswith("?") else f"{fault.rstrip('.')}." for fault in faults]
    if len(sentences) == 1:
        return SceneError(f"scene {source}: {sentences[0]}")
    return SceneError("\n  ".join([f"scene {source} has {len(sentences)} faults:", *sentences]))


def explain(error: ValidationError, root: type[Table]) -> list[str]:
    """One sentence for each fault, with its path, what was wanted and what came."""
    return [_sentence(finding, root) for finding in error.errors()]


def _sentence(finding: Mapping[str, Any], root: type[Table]) -> str:
    steps, tables = _walk(finding["loc"], root)
    if not steps:  # a fault of the scene as a whole
        return str(finding["msg"])
    path, key, context = _path(steps), finding["loc"][-1], finding.get("ctx", {})
    match finding["type"]:
        case "fault":
            sentence = str(finding["msg"])
            return f"{path} {sentence}" if sentence.startswith(("should", "needs", "is not")) else f"{path}: {sentence}"
        case "missing":
            return f"{path} is missing; give it"
        case "extra_forbidden":
            known = [name for table in tables for name in table.model_fields]
            return f"{path} is not a key of a scene; remove it.{did_you_mean(str(key), known)}"
        case "union_tag_not_found":
            return f"{path}.kind is missing; it is one of {_tags(tables)}"
        case "union_tag_invalid":
            guess = did_you_mean(context["tag"], _kinds(tables))
            return f"{path}.kind should be one of {_tags(tables)}, but is {context['tag']!r}.{guess}"
        case "literal_error":
            guess = did_you_mean(str(finding["input"]), context["expected"].split("'")[1::2])
            return f"{path} should be {context['expected']}, but is {finding['input']!r}.{guess}"
        case "model_type" | "model_attributes_type" | "dict_type":
            return f"{path} should be a table, but is {_shown(finding['input'])}"
        case "too_short" | "too_long":
            least, most = context.get("min_length"), context.get("max_length")
            wanted = f"{least} or more" if most is None else f"{most} or fewer"
            return f"{path} should have {wanted} entries, but has {context['actual_length']}"
        case _:
            wanted = str(finding["msg"]).removeprefix("Input ")
            return f"{path} {wanted[0].lower()}{wanted[1:]}, but is {_shown(finding['input'])}"


def _walk(location: Location, root: type[Table]) -> tuple[Location, list[type[Table]]]:
    """The location without the tags of unions, and the tables it leads to, or those its unknown last key is none of."""
    steps: list[int | str] = []
    tables: list[type[Table]] = [root]
    owners = tables
    for step in location:
        tagged = [table for table in tables if step in (table.__name__, *_tags_of(table))]
        if isinstance(step, str) and tagged:
            tables = owners = tagged
            continue
        steps.append(step)
        if isinstance(step, str):
            owners = tables
            tables = [table for owner in owners for table in _tables_in(_annotation(owner, step))]
    return tuple(steps), tables or owners


def _annotation(table: type[Table], key: str) -> Any:
    field = table.model_fields.get(key)
    return field.annotation if field else None


def _tables_in(annotation: Any) -> Iterator[type[Table]]:
    if isinstance(annotation, type) and issubclass(annotation, Table):
        yield annotation
    for argument in get_args(annotation):
        yield from _tables_in(argument)


def _tags_of(table: type[Table]) -> tuple[str, ...]:
    annotation = _annotation(table, "kind")
    return get_args(annotation) if get_origin(annotation) is Literal else ()


def _kinds(tables: list[type[Table]]) -> list[str]:
    return [tag for table in tables for tag in _tags_of(table)]


def _tags(tables: list[type[Table]]) -> str:
    return ", ".join(_kinds(tables))


def _path(steps: Location) -> str:
    return "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in steps).removeprefix(".")


def _shown(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
