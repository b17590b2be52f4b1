"""The page of a tradeoff: where to spend, then a section for each axis with its diagram, sentences and table."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from springopt.report.pages import Block, Bullets, Cells, Code, Heading, Picture, Words, write_page
from springopt.report.tradeoff.figure import draw_tradeoff
from springopt.report.tradeoff.rows import heads, rows, sentences

READING = (
    "Every point is a setting: its error over the processor time that it takes, the median of repeats with the "
    "interval that holds the median with 95 % (of fewer than six repeats their range). Down is more accurate, left is "
    "faster; the grey steps are the Pareto front, a ring is what the scene states, hollow points have answers in some "
    "cases only, and crosses at the upper edge have none. A dotted series is judged by another truth than the rest. "
    "Warm-up is the first call, on the wall; times are without it."
)


def write_tradeoff(page: Path, document: Mapping[str, Any], command: str) -> None:
    """The page of a document of `springopt.tradeoff`, made by this command, as HTML or as Markdown beside pictures."""
    write_page(page, list(_blocks(document, command)))


def _blocks(document: Mapping[str, Any], command: str) -> Iterator[Block]:
    machine = document["machine"]
    yield Heading(f"What accuracy costs in time: {document['scene']}", 1)
    yield Words(f"{document['title']}.")
    yield Code(command)
    yield Words(f"springopt {machine['springopt']} on {machine['processor']}, {machine['cores']} cores.")
    yield Words(READING)
    said = [*document["where_to_spend"], *(answer["said"] for answer in document["answers"])]
    if said:
        yield Heading("Where to spend")
        yield Bullets(said)
    for axis in document["axes"]:
        yield from _section(axis)
    if document["missing"]:
        yield Heading("What this scene does not have")
        yield Bullets([f"{name}: {why}." for name, why in document["missing"].items()])


def _section(axis: Mapping[str, Any]) -> Iterator[Block]:
    yield Heading(axis["title"])
    yield Words(f"Error: {axis['error']}. Time: {axis['time']}. Measured for {axis['seconds']:.0f} s.")
    yield Picture(axis["axis"], draw_tradeoff(axis), f"{axis['title']}: error over processor time")
    said = sentences(axis)
    if said:
        yield Bullets(said)
    yield Cells(heads(axis), list(rows(axis)))
