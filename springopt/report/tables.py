"""Tables for people: errors by load case, stiffness by class of springs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from rich import box
from rich.table import Table

MEASURES = {"distance": "distance", "relative_distance": "relative", "least_squares": "least squares"}
ROLES = {"train": "training", "test": "test"}


def plain_table(title: str, names: Iterable[str], numbers: Iterable[str]) -> Table:
    """An empty table in the house style: columns of names to the left, of numbers to the right."""
    table = Table(title=title, title_justify="left", title_style="bold", box=box.SIMPLE_HEAD, pad_edge=False)
    for heading in names:
        table.add_column(heading, no_wrap=True)
    for heading in numbers:
        table.add_column(heading, justify="right", no_wrap=True)
    return table


def errors_table(errors: Sequence[Mapping[str, Any]]) -> Table:
    """One row a load case, and for each role the sums: for training they are the objective in each definition."""
    table = plain_table("Errors", ["load case", "role"], [*MEASURES.values(), "largest"])
    table.add_column("status", no_wrap=True)
    for role, heading in ROLES.items():
        rows = [error for error in errors if error["role"] == role]
        for row in rows:
            table.add_row(row["name"], heading, *_numbers(row), str(row["status"]))
        if rows:
            sums = {measure: _sum(row[measure] for row in rows) for measure in MEASURES}
            sums["max_distance"] = max((row["max_distance"] for row in rows), key=lambda x: -1 if x is None else x)
            label = "sum: the objective in each definition" if role == "train" else "sum"
            table.add_row(label, heading, *_numbers(sums), "", style="bold", end_section=True)
    table.caption = (
        "distance: mean over the nodes; relative: the same over the smallest rest length; "
        "least squares: half the sum of squares; largest: of any node"
    )
    table.caption_justify = "left"
    return table


def classes_table(classes: Mapping[str, Mapping[str, float]]) -> Table:
    """One row a class of springs."""
    table = plain_table("Stiffness", ["class"], ["springs", "present", "mean", "spread"])
    for name, row in classes.items():
        table.add_row(name, f"{row['springs']:g}", f"{row['present']:g}", f"{row['mean']:.4g}", f"{row['spread']:.3g}")
    return table


def simulation_table(title: str, answers: Sequence[Mapping[str, Any]]) -> Table:
    """One row a load case: how the forward solve ended, and how far from the reference."""
    table = plain_table(title, ["load case", "role", "status"], ["energy", "residual", *MEASURES.values(), "largest"])
    for answer in answers:
        forward = [f"{answer['energy']:.6g}", f"{answer['residual']:.1e}"]
        table.add_row(answer["name"], ROLES[answer["role"]], str(answer["status"]), *forward, *_numbers(answer))
    return table


def optimizers_table(entries: Iterable[Mapping[str, Any]]) -> Table:
    """Name, distribution and summary."""
    table = plain_table("Optimizers", ["name", "distribution", "what it does"], [])
    for entry in entries:
        table.add_row(entry["name"], entry["distribution"], entry["summary"])
    return table


def options_table(options: Iterable[Mapping[str, Any]]) -> Table:
    """Options with their types, defaults and explanations."""
    table = plain_table("Options", ["option", "type", "default"], [])
    table.add_column("explanation", overflow="fold")
    for option in options:
        table.add_row(option["name"], option["type"], str(option["default"]), option["explanation"])
    return table


def scenes_table(entries: Iterable[Mapping[str, str]]) -> Table:
    """Name and title."""
    table = plain_table("Bundled scenes", ["name", "title"], [])
    for entry in entries:
        table.add_row(entry["name"], entry["title"])
    return table


def _numbers(row: Mapping[str, float | None]) -> list[str]:
    return [_number(row[measure]) for measure in (*MEASURES, "max_distance")]


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.4g}"


def _sum(values: Iterable[float | None]) -> float | None:
    numbers = list(values)
    return None if None in numbers else sum(number for number in numbers if number is not None)
