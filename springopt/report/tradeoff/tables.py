"""The tables of a tradeoff in the terminal."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rich.markup import escape
from rich.table import Table

from springopt.report.tables import plain_table
from springopt.report.tradeoff.rows import NAMES, TEXTS, heads, rows


def tradeoff_table(axis: Mapping[str, Any]) -> Table:
    """One row a setting, those of the Pareto front in bold."""
    columns = heads(axis)
    table = plain_table(
        f"{axis['title']} (error: {axis['error']}; time: {axis['time']})",
        columns[:NAMES],
        columns[NAMES:-TEXTS],
        columns[-TEXTS:],
    )
    for point, row in zip(axis["points"], rows(axis), strict=True):
        table.add_row(*(escape(cell) for cell in row), style="bold" if point["on_front"] else None)
    return table
