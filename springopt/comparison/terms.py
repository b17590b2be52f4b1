"""On what terms runs are compared: one scene, one setting for each name, one budget."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import groupby
from typing import Any

from springopt.comparison.record import Record
from springopt.errors import UserError


def on_equal_terms(records: Sequence[Record]) -> tuple[list[Record], list[str]]:
    """The records in order, those of one name with different settings under different names; and what to know of it.

    Raises UserError where runs under one scene's name are on different scenes, or two are the same run.
    """
    named: list[Record] = []
    notes: list[str] = []
    for _, group in grouped(records, "scene"):
        _require_one_scene(group)
    for _, group in grouped(records, "scene", "method"):
        apart, note = _kept_apart(group)
        named += apart
        notes += note
    for _, group in grouped(named, "scene", "method", "seed"):
        _require_single(group)
    for _, group in grouped(named, "scene"):
        notes += _unequal_budgets(group)
    return named, notes + _unequal_processors(named) + _unequal_builds(named)


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


def _kept_apart(records: list[Record]) -> tuple[list[Record], list[str]]:
    """Runs of one method on one scene; where their settings differ, each has the difference in its name."""
    settings = [_setting(record) for record in records]
    names = sorted({name for setting in settings for name in setting})
    differing = [name for name in names if len({repr(setting.get(name)) for setting in settings}) > 1]
    if not differing:
        return records, []
    first = records[0]
    apart = [
        replace(record, method=f"{record.method} ({', '.join(f'{name}={setting.get(name)}' for name in differing)})")
        for record, setting in zip(records, settings, strict=True)
    ]
    return apart, [f"the runs of {first.method} on {first.scene} differ in {', '.join(differing)}: kept apart by name."]


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
