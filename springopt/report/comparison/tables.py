"""Tables of a comparison of optimizers, for people.

They take the comparison as a document: what `Comparison` has, as dictionaries and lists.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rich.table import Table
from rich.text import Text

from springopt.report.comparison import said
from springopt.report.comparison.said import SOLVED, UNITS
from springopt.report.tables import captioned, plain_table

Document = Mapping[str, Any]


def gap_tables(comparison: Document, width: int) -> list[Table]:
    """The median gap of each method on each scene, or why there is none; as many columns a table as the width holds.

    The longer of the two lists makes the rows.
    """
    methods = [each["method"] for each in comparison["methods"]]
    methods += sorted({each["method"] for each in comparison["refusals"]} - set(methods))
    scenes = [each["scene"] for each in comparison["scenes"]]
    cells = _gap_cells(comparison)
    if len(scenes) > len(methods):
        grid = [[cells.get((scene, method), Text("-")) for method in methods] for scene in scenes]
        tables = _split("scene", scenes, methods, grid, width)
    else:
        grid = [[cells.get((scene, method), Text("-")) for scene in scenes] for method in methods]
        tables = _split("optimizer", methods, scenes, grid, width)
    captioned(
        tables[-1],
        "Median gap over the runs: the share of the way from the start to the floor that is left. "
        "solved: at most 1e-6; bold: the lowest on the scene; a word: why the optimizer can't serve the scene, or "
        "that all its runs failed; =: all runs, whatever their seeds, are the same; !: of the others, some failed.",
    )
    return tables


def running_time_table(comparison: Document) -> Table:
    """How often and how fast each method reached the target, over its scenes."""
    target = comparison["target"]
    table = plain_table(
        f"Expected running time to {said.power(target)} of the way, times the best",
        ["optimizer"],
        ["reached", "success", *UNITS.values()],
    )
    for each in comparison["methods"]:
        ratios = [said.ratio(each["times_the_best"][unit]) for unit in UNITS]
        counts = f"{each['reached']} of {each['scenes']}", f"{each['success_rate']:.0%}{said.failed(each['failed'])}"
        table.add_row(each["method"], *counts, *ratios)
    return captioned(
        table,
        "reached: scenes where at least one run got there; success: share of the runs that did, mean over scenes; "
        "times the best: over the expected running time of the fastest optimizer, median over those of its scenes "
        "where any got there; never: it did on at most half of them.",
    )


def ranking_table(comparison: Document) -> Table:
    """Mean ranks over the scenes that all ranked methods serve, with the tests over and within scenes."""
    ranking = comparison["ranking"]
    table = plain_table(
        f"Ranks over {len(ranking['scenes'])} scenes",
        ["optimizer"],
        ["mean rank", "from the best", "p", "effect", "better", "even", "worse"],
    )
    best, *_ = ranking["mean_ranks"]
    against = {pair["second"]: pair for pair in ranking["pairs"] if pair["first"] == best}
    within = {each["method"]: each for each in comparison["methods"]}
    for method, rank in ranking["mean_ranks"].items():
        pair, summary = against.get(method), within[method]
        tests = (said.p_value(pair["p_holm"]), f"{0.0 - pair['rank_biserial']:+.2f}") if pair else ("", "")
        difference = f"+{rank - ranking['mean_ranks'][best]:.2f}" if pair else ""
        counts = (str(summary[name]) for name in ("better", "even", "worse"))
        table.add_row(method, f"{rank:.2f}", difference, *tests, *counts)
    return captioned(table, " ".join(_ranking_sentences(ranking, comparison["block"])))


def cost_table(comparison: Document) -> Table:
    """Held-out error beside the training error, and what is not forward solve."""
    table = plain_table(
        "Test error and overhead",
        ["optimizer"],
        ["runs", "training error", "test error", "overhead", "for each evaluation"],
    )
    for each in comparison["methods"]:
        errors = said.error(each["train_error"]), said.error(each["test_error"])
        overhead = f"{each['overhead_share']:.0%}", said.seconds(each["overhead_per_evaluation"])
        table.add_row(each["method"], f"{each['runs']}{said.failed(each['failed'])}", *errors, *overhead)
    return captioned(
        table,
        "errors: mean distance of the nodes over the smallest rest length, mean over the load cases, on scenes with "
        "test load cases; overhead: processor time outside forward solves and derivatives. Medians over scenes.",
    )


def _gap_cells(comparison: Document) -> dict[tuple[str, str], Text]:
    """(scene, method) -> the median gap, or the word of the refusal."""
    cells = {(each["scene"], each["method"]): Text(each["word"], "dim") for each in comparison["refusals"]}
    for scene in comparison["scenes"]:
        lowest = max(min(each["gap"]["median"] for each in scene["methods"]), SOLVED)
        for each in scene["methods"]:
            gap = each["gap"]["median"]
            text = said.gap(gap) + ("=" if each["deterministic"] else "") + ("!" if each["failed"] else "")
            cells[scene["scene"], each["method"]] = Text(text, "bold" if gap <= lowest else "")
    return cells


def _split(what: str, rows: Sequence[str], columns: Sequence[str], grid: list[list[Text]], width: int) -> list[Table]:
    """Tables side by side in one: as many columns in each as fit."""
    headings = [_folded(name) for name in columns]
    first = max(len(what), *map(len, rows)) + 2
    widths = [
        max([len(line) for line in heading.split("\n")] + [len(row[i]) for row in grid]) + 2
        for i, heading in enumerate(headings)
    ]
    tables: list[Table] = []
    begin = 0
    while begin < len(columns):
        end, used = begin + 1, first + widths[begin]
        while end < len(columns) and used + widths[end] <= width:
            used, end = used + widths[end], end + 1
        table = plain_table("" if tables else "Median gap to the floor", [what], headings[begin:end])
        for name, row in zip(rows, grid, strict=True):
            table.add_row(name, *row[begin:end])
        tables.append(table)
        begin = end
    return tables


def _folded(name: str) -> str:
    """A heading in lines of at most some ten characters, broken at hyphens and blanks."""
    lines = [""]
    for part in name.replace("-", "-\0").replace(" ", " \0").split("\0"):
        if lines[-1] and len(lines[-1]) + len(part.strip()) > 10:
            lines.append("")
        lines[-1] += part
    return "\n".join(line.strip() for line in lines)


def _ranking_sentences(ranking: Document, block: Document) -> list[str]:
    friedman = ranking["friedman"]
    sentences = [f"Critical difference of mean ranks {ranking['critical_difference']:.2f} (Nemenyi, 5 %)."]
    if friedman:
        f = "-" if friedman["f"] is None else f"{friedman['f']:.2f}"
        sentences.append(
            f"Friedman: chi-square {friedman['chi_square']:.2f}, p {said.p_value(friedman['p'])}; Iman and Davenport: "
            f"F {f}, p {said.p_value(friedman['p_f'])}; Kendall's W {friedman['kendall_w']:.2f}."
        )
    sentences.append(
        "p: Wilcoxon's test of scene medians against the first, with Holm's correction for all pairs; effect: "
        "matched-pairs rank-biserial correlation, -1 where it is behind on every scene. better, even, worse: tests of "
        "final values within scenes, against each other optimizer."
    )
    for kind in ("methods", "scenes"):
        sentences += _left_out(block[f"{kind}_left_out"])
    return sentences


def _left_out(reasons: Mapping[str, str]) -> list[str]:
    """One sentence a reason."""
    names: dict[str, list[str]] = {}
    for name, why in reasons.items():
        names.setdefault(why, []).append(name)
    return [f"Without {', '.join(its)}: {why}." for why, its in names.items()]
