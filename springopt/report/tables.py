"""Tables for people: errors by load case, stiffness by class of springs, the front."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from rich import box
from rich.markup import escape
from rich.table import Table

if TYPE_CHECKING:
    from springopt.front import Front

MEASURES = {"distance": "distance", "relative_distance": "relative", "least_squares": "squares"}
LONGEST_FRONT = 24  # rows
SCENES_ABREAST = 6


def plain_table(title: str, names: Iterable[str], numbers: Iterable[str] = (), texts: Iterable[str] = ()) -> Table:
    """An empty table in the house style: names to the left, numbers to the right, then texts that may wrap."""
    table = Table(
        title=title, title_justify="left", title_style="bold", box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0)
    )
    for heading in names:
        table.add_column(heading, no_wrap=True)
    for heading in numbers:
        table.add_column(heading, justify="right", no_wrap=True)
    for heading in texts:
        table.add_column(heading)
    return table


def captioned(table: Table, caption: str) -> Table:
    """The table with a caption below, to the left; wide enough to read it."""
    table.caption, table.caption_justify, table.min_width = caption, "left", 72
    return table


def errors_table(errors: Sequence[Mapping[str, Any]]) -> Table:
    """One row a load case, and the sums for each role."""
    table = plain_table("Errors", ["load case", "role"], [*MEASURES.values(), "largest"], ["status"])
    for role in ("train", "test"):
        rows = [error for error in errors if error["role"] == role]
        for row in rows:
            table.add_row(row["name"], role, *_numbers(row), str(row["status"]))
        if rows:
            sums = {measure: _sum(row[measure] for row in rows) for measure in MEASURES}
            sums["max_distance"] = max((row["max_distance"] for row in rows), key=lambda x: -1 if x is None else x)
            table.add_row("sum", role, *_numbers(sums), "", style="bold", end_section=True)
    table.caption = (
        "distance: mean over the nodes; relative: the same over the smallest rest length; "
        "squares: half the sum of squared differences; largest: distance of any node. "
        "The sums over train are the objective in its three definitions."
    )
    table.caption_justify = "left"
    return table


def classes_table(classes: Mapping[str, Mapping[str, float]]) -> Table:
    """One row a class of springs."""
    table = plain_table("Stiffness", ["class"], ["springs", "present", "mean", "spread"])
    for name, row in classes.items():
        table.add_row(name, f"{row['springs']:g}", f"{row['present']:g}", f"{row['mean']:.4g}", f"{row['spread']:.3g}")
    return table


def front_table(front: Front, spring_count: int) -> Table:
    """One row a point of the front, the fewest springs first; of a long one every so many, from end to end."""
    shown = sorted({round(i * (len(front) - 1) / (LONGEST_FRONT - 1)) for i in range(LONGEST_FRONT)})
    title = "Front" if len(shown) == len(front) else f"Front, {len(shown)} of {len(front)} points"
    table = plain_table(title, [], ["springs", "share", "objective"])
    for i in shown:
        table.add_row(f"{front.springs[i]}", f"{front.springs[i] / spring_count:.1%}", f"{front.values[i]:.4g}")
    return table


def effects_table(effects: Sequence[Mapping[str, Any]]) -> Table:
    """One row an effect: what it brings to the forward solve."""
    table = plain_table("Effects", ["effect"], texts=["what it brings"])
    for effect in effects:
        table.add_row(effect["name"], effect["brings"])
    return table


def engines_table(supports: Sequence[Mapping[str, Any]]) -> Table:
    """One row a set of supports: its engine and solver, and why."""
    table = plain_table(
        "Engines", ["engine", "solver"], ["unknowns", "half-bandwidth"], ["load cases with the same supports", "why"]
    )
    for row in supports:
        sizes = f"{row['unknowns']:,}", f"{row['half_bandwidth']:,}"
        table.add_row(row["engine"], row["solver"], *sizes, ", ".join(row["load_cases"]), row["why"])
    return table


def unseen_table(unseen: Sequence[Mapping[str, Any]], springs: Sequence[Mapping[str, Any]]) -> Table:
    """One row a reason: how many springs no load case sees for it, and which, with their nodes."""
    table = plain_table("Springs that no load case sees", [], ["springs"], ["why", "which"])
    reasons: dict[str, list[int]] = {}
    for row in unseen:
        reasons.setdefault(row["why"], []).append(row["spring"])
    for why, members in reasons.items():
        shown = ", ".join(f"{spring} ({_pair(springs[spring]['nodes'])})" for spring in members[:12])
        table.add_row(f"{len(members)}", why, shown + (", ..." if len(members) > 12 else ""))
    return table


def precision_table(springs: Sequence[Mapping[str, Any]]) -> Table:
    """The eight springs with the largest standard errors, and the four with the smallest."""
    table = plain_table("Identified springs, worst and best", ["spring", "nodes"], ["stiffness", "standard error"])
    table.add_column("seen best in")
    worst_first = sorted(springs, key=lambda row: -row["standard_error"])
    shown = worst_first if len(springs) <= 12 else [*worst_first[:8], None, *worst_first[-4:]]
    for row in shown:
        if row is None:
            table.add_section()
            continue
        numbers = f"{row['stiffness']:.4g}", f"{row['standard_error']:.3g}"
        table.add_row(str(row["spring"]), _pair(row["nodes"]), *numbers, row["seen_best_in"])
    return table


def design_table(criterion: str, picks: Sequence[Mapping[str, Any]]) -> Table:
    """One row a load case that was picked: what it brings beside those above it."""
    numbers = ["gain", "known", "smallest", "identified", "largest error"]
    table = plain_table(f"Load cases that help most, {criterion}-optimal", ["load case"], numbers)
    for pick in picks:
        error = _number(pick["largest_standard_error"])
        counts = f"{pick['known']:,}", f"{pick['smallest']:.4g}", f"{pick['identified']:,}"
        table.add_row(pick["name"], f"{pick['gain']:.4g}", *counts, error)
    table.caption = (
        "gain: of the log determinant of the information; known: directions of which the data tell more than the box; "
        "smallest: eigenvalue among them, in units of the box; identified: springs; "
        "largest error: the largest standard error of these. Each row holds with those above it."
    )
    table.caption_justify = "left"
    return table


def simulation_table(title: str, answers: Sequence[Mapping[str, Any]]) -> Table:
    """One row a load case: how the forward solve ended, and how far from the reference."""
    table = plain_table(title, ["load case", "role"], ["energy", "residual", "distance", "largest"], ["status"])
    for answer in answers:
        energy = np.ravel(answer["energy"])[-1]  # in motion that at the last time
        forward = [f"{energy:.6g}", f"{answer['residual']:.1e}"]
        errors = [_number(answer["distance"]), _number(answer["max_distance"])]
        table.add_row(answer["name"], answer["role"], *forward, *errors, str(answer["status"]))
    return table


def optimizers_table(entries: Iterable[Mapping[str, Any]]) -> Table:
    """Name, distribution and summary."""
    table = plain_table("Optimizers", ["name", "distribution"], texts=["what it does"])
    for entry in entries:
        table.add_row(entry["name"], entry["distribution"], entry["summary"])
    return table


def installed_effects_table(entries: Iterable[Mapping[str, Any]]) -> Table:
    """Name, distribution, what each brings and its summary."""
    table = plain_table("Effects", ["name", "distribution"], texts=["brings", "what it is"])
    for entry in entries:
        table.add_row(entry["name"], entry["distribution"], ", ".join(entry["brings"]), entry["summary"])
    return table


def options_table(options: Iterable[Mapping[str, Any]]) -> Table:
    """Options with their types, defaults and explanations."""
    table = plain_table("Options", ["option"], texts=["type", "default", "explanation"])
    for option in options:
        table.add_row(option["name"], option["type"], str(option["default"]), escape(option["explanation"]))
    return table


def checks_table(name: str, findings: Iterable[Mapping[str, str]]) -> Table:
    """Checks of a plugin, each with its verdict and what to mend."""
    table = plain_table(f"Checks of {name}", ["check", "verdict"], texts=["what to mend"])
    for finding in findings:
        table.add_row(finding["check"], finding["verdict"], finding["sentence"])
    return table


def scenes_table(entries: Sequence[Mapping[str, Any]]) -> Table:
    """Group, name and title, a section for each group; the distribution, where there is more than one."""
    brought = len({entry["distribution"] for entry in entries}) > 1
    table = plain_table("Scenes", ["group", "name", *(["distribution"] if brought else [])], texts=["title"])
    for entry, last in zip(entries, [None, *entries], strict=False):
        begins = last is None or entry["group"] != last["group"]
        if begins:
            table.add_section()
        owner = [entry["distribution"]] if brought else []
        table.add_row((entry["group"] or "-") if begins else "", entry["name"], *owner, entry["title"])
    return table


def benchmark_tables(scenes: Sequence[str], rows: Mapping[str, Mapping[str, str]]) -> Iterable[Table]:
    """One row an optimizer, one column a scene; a few scenes a table, so that it fits a terminal."""
    for first in range(0, len(scenes), SCENES_ABREAST):
        abreast = scenes[first : first + SCENES_ABREAST]
        table = plain_table("Ended runs", ["optimizer"], [scene.replace("-", "-\n") for scene in abreast])
        for name, cells in rows.items():
            table.add_row(name, *(cells.get(scene, "-") for scene in abreast))
        yield table


def floors_table(entries: Sequence[Mapping[str, Any]]) -> Table:
    """Name, unknowns, the value to begin with, the floor, and how sure it is."""
    table = plain_table("Floors", ["name"], ["unknowns", "start", "floor"], ["how sure"])
    for entry in entries:
        floor = "-" if entry["floor"] is None else f"{entry['floor']:.9g}"
        table.add_row(entry["name"], f"{entry['unknowns']:,}", _number(entry["start"]), floor, _sure(entry))
    return table


def _sure(entry: Mapping[str, Any]) -> str:
    if entry["floor"] is None:
        return "none is stored"
    if entry["proven"]:
        return "proven"
    starts, agreed = entry["evidence"].get("starts"), entry["evidence"].get("agreed")
    return f"best known; {agreed} of {starts} starts ended there" if starts else "best known"


def _pair(nodes: Sequence[int]) -> str:
    return f"{nodes[0]} - {nodes[1]}"


def _numbers(row: Mapping[str, float | None]) -> list[str]:
    return [_number(row[measure]) for measure in (*MEASURES, "max_distance")]


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.4g}"


def _sum(values: Iterable[float | None]) -> float | None:
    numbers = list(values)
    return None if None in numbers else sum(number for number in numbers if number is not None)
