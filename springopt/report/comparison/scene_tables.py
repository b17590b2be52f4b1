"""Tables of one scene of a comparison, in full."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rich.table import Table

from springopt.report.comparison import said
from springopt.report.comparison.said import UNITS
from springopt.report.tables import captioned, plain_table

Document = Mapping[str, Any]

LONGEST_LIST = 21  # pairs, of seven methods


def scene_tables(scene: Document, target: int) -> list[Table]:
    """One scene in full: values, running times, errors and tests."""
    return [_values_table(scene), _times_table(scene, target), _errors_table(scene), _pairs_table(scene)]


def _values_table(scene: Document) -> Table:
    table = plain_table(
        f"{scene['scene']}: final values ({scene['minimize']})",
        ["optimizer"],
        ["runs", "median", "quartiles", "gap", "quartiles of the gap", "evaluations"],
        ["stopped by"],
    )
    for each in scene["methods"]:
        value, gap = each["value"], each["gap"]
        same = ", all the same" if each["deterministic"] else ""
        stopped = ", ".join(f"{why} ({count})" for why, count in each["stopped"].items())
        table.add_row(
            each["method"],
            f"{each['runs']}{said.failed(each['failed'])}{same}",
            f"{value['median']:.6g}",
            f"{value['lower_quartile']:.5g} to {value['upper_quartile']:.5g}",
            said.gap(gap["median"]),
            f"{said.gap(gap['lower_quartile'])} to {said.gap(gap['upper_quartile'])}",
            f"{each['cost']['evaluations']:,.0f}",
            stopped,
        )
    way = scene["way"]
    sure = "proven" if way["proven"] else "best known"
    return captioned(table, f"start {way['start']:.6g} ({way['start_is']}); floor {way['floor']:.9g} ({sure}).")


def _times_table(scene: Document, target: int) -> Table:
    table = plain_table(
        f"{scene['scene']}: expected running time to {said.power(target)} of the way",
        ["optimizer"],
        ["success", *UNITS.values()],
    )
    for each in scene["methods"]:
        reached = each["targets"][target]
        times = (said.estimate(reached["running_times"][unit]) for unit in UNITS)
        runs = f"{each['runs'] + each['failed']}{said.failed(each['failed'])}"
        rate = f"{reached['successes']} of {runs}{_interval(reached['rate'])}"
        table.add_row(each["method"], rate, *times)
    return captioned(
        table,
        "95 % intervals: Wilson's of the success rate, none where all runs are the same; by the bootstrap over the "
        "runs of the times; unsuccessful runs count with what they spent.",
    )


def _errors_table(scene: Document) -> Table:
    table = plain_table(
        f"{scene['scene']}: errors and cost, medians",
        ["optimizer"],
        ["training error", "test error", "processor seconds", "in solves", "overhead"],
    )
    for each in scene["methods"]:
        cost, test = each["cost"], each["test_error"]
        seconds = (cost[f"{name}_seconds"] for name in ("processor", "solving", "overhead"))
        errors = f"{each['train_error']['median']:.4g}", "-" if test is None else f"{test['median']:.4g}"
        table.add_row(each["method"], *errors, *map(said.seconds, seconds))
    return table


def _pairs_table(scene: Document) -> Table:
    """A list of few pairs, a matrix of many."""
    return _pairs_list(scene) if len(scene["pairs"]) <= LONGEST_LIST else _pairs_matrix(scene)


def _pairs_list(scene: Document) -> Table:
    table = plain_table(
        f"{scene['scene']}: which runs end lower",
        ["optimizer", "beside"],
        ["probability of ending lower", "p", "p (Holm)"],
        ["ends lower", "test"],
    )
    for pair in scene["pairs"]:
        p_values = said.p_value(pair["p"]), said.p_value(pair["p_holm"])
        lower = pair["ends_lower"] or "-"
        table.add_row(pair["first"], pair["second"], said.estimate(pair["lower"]), *p_values, lower, pair["test"])
    return captioned(table, "With 95 % intervals; ends lower: at 5 % after Holm's correction for all pairs.")


def _pairs_matrix(scene: Document) -> Table:
    methods = [each["method"] for each in scene["methods"]]
    numbers = [f"{number}" for number in range(1, len(methods) + 1)]
    table = plain_table(f"{scene['scene']}: probability of ending lower", ["", "optimizer"], numbers[1:])
    cells = {(pair["first"], pair["second"]): _cell(pair) for pair in scene["pairs"]}
    for number, method in zip(numbers, methods, strict=True):
        table.add_row(number, method, *(cells.get((method, other), "") for other in methods[1:]))
    return captioned(
        table,
        "Of a run of the row's optimizer beside one of the column's, ties half; *: at 5 % after Holm's correction for "
        "all pairs, or neither is random. --csv and --json have intervals and p.",
    )


def _cell(pair: Document) -> str:
    return f"{pair['lower']['value']:.2f}{'*' if pair['ends_lower'] else ' '}"


def _interval(rate: Document) -> str:
    """In brackets, where it has a width."""
    return "" if rate["low"] == rate["high"] else f" ({rate['low']:.0%} to {rate['high']:.0%})"
