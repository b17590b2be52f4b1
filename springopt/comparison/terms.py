"""On what terms runs are compared: one scene, one setting for each name, one budget."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import groupby
from typing import Any

from springopt.comparison.record import Record
from springopt.errors import UserError


def kept_apart(records: Sequence[Record]) -> tuple[list[Record], list[str]]:
    """The records in order, those of one label with different settings as different methods; and what to know of it.

    What differs on one scene is in the names on all, so that a method is called the same wherever it has runs.
    """
    named: list[Record] = []
    notes: list[str] = []
    for (label,), group in grouped(records, "label"):
        differing = {scene: _differing(its) for (scene,), its in grouped(group, "scene")}
        names = sorted(set[str]().union(*differing.values()))
        named += [replace(record, method=_apart(record, names)) for record in group]
        if names:
            scenes = ", ".join(scene for scene, its in differing.items() if its)
            notes.append(f"the runs of {label} on {scenes} differ in {', '.join(names)}: kept apart by name.")
    return [record for _, group in grouped(named, "scene", "method") for record in group], notes


def on_equal_terms(records: Sequence[Record]) -> list[str]:
    """What a reader must know of records that are kept apart.

    Raises UserError where runs under one scene's name are on different scenes, or two are the same run.
    """
    for _, group in grouped(records, "scene"):
        _require_one_scene(group)
    for _, group in grouped(records, "scene", "method", "seed"):
        _require_single(group)
    unequal = [note for _, group in grouped(records, "scene") for note in _unequal_budgets(group)]
    return unequal + _unequal_processors(records) + _unequal_builds(records)


def grouped(records: Iterable[Record], *names: str) -> Iterator[tuple[tuple[Any, ...], list[Record]]]:
    """Records by what they have under these names, in order."""

    def key(record: Record) -> tuple[Any, ...]:
        return tuple(getattr(record, name) for name in names)

    for value, group in groupby(sorted(records, key=lambda each: (key(each), each.seed)), key):
        yield value, list(group)


def _require_one_scene(records: Sequence[Record]) -> None:
    first = records[0]
    for other in records:
        if other.digest != first.digest:
            raise UserError(
                f"{first.path} and {other.path} are runs on two states of a scene, both called {first.scene}; "
                "compare them apart."
            )
        if other.tests != first.tests:
            raise UserError(
                f"{first.path} and {other.path} are runs with different test load cases on scenes that are both called "
                f"{first.scene}; compare them apart."
            )


def _require_single(records: Sequence[Record]) -> None:
    if len(records) > 1:
        first, second = records[:2]
        raise UserError(
            f"{first.path} and {second.path} are the same run, {first.method} on {first.scene} with seed {first.seed}; "
            "leave one of them out."
        )


def _differing(records: Sequence[Record]) -> set[str]:
    """Names of the settings that these runs do not share."""
    settings = [_setting(record) for record in records]
    names = {name for setting in settings for name in setting}
    return {name for name in names if len({repr(setting.get(name)) for setting in settings}) > 1}


def _apart(record: Record, names: Sequence[str]) -> str:
    """The label, with these settings behind it."""
    setting = _setting(record)
    return f"{record.label} ({', '.join(f'{name}={setting.get(name)}' for name in names)})" if names else record.label


def _setting(record: Record) -> dict[str, Any]:
    return {
        **record.options,
        "start": record.start,
        **{f"budget of {name}": limit for name, limit in record.budget.items()},
    }


def _unequal_budgets(records: Sequence[Record]) -> list[str]:
    """A sentence if the runs on a scene could not spend alike."""
    budgets = {", ".join(f"{limit:g} {name}" for name, limit in sorted(each.budget.items())) for each in records}
    if len(budgets) == 1:
        return []
    return [
        f"the runs on {records[0].scene} had different budgets ({'; '.join(sorted(budgets))}): "
        "their running times can be compared, their final values are of unequal effort."
    ]


def _unequal_processors(records: Sequence[Record]) -> list[str]:
    processors = {record.processor for record in records}
    if len(processors) == 1:
        return []
    return [f"the runs were made on {len(processors)} types of processor: their seconds can't be compared."]


def _unequal_builds(records: Sequence[Record]) -> list[str]:
    """A sentence if the runs of a method were made by different builds."""
    methods: dict[str, set[str]] = {}
    for (method,), group in grouped(records, "method"):
        names = {name for each in group for name in each.build}
        differing = {name for name in names if len({each.build.get(name) for each in group}) > 1}
        if differing:
            methods[method] = differing
    if not methods:
        return []
    parts = ", ".join(sorted(set[str]().union(*methods.values())))
    return [
        f"the runs of {', '.join(methods)} were made by builds that differ in {parts}: such a name stands for several "
        "states of it."
    ]
