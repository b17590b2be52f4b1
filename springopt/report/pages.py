"""Pages of headings, words, tables and pictures: HTML in one file, or Markdown beside its pictures."""

from __future__ import annotations

import io
import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from textwrap import fill
from typing import Any

from matplotlib import rc_context

from springopt.errors import UserError
from springopt.report import style
from springopt.report.figures import save

_LOOK = """
body { font: 16px/1.5 system-ui, sans-serif; max-width: 62rem; margin: 2rem auto; padding: 0 1rem; color: #222; }
table { border-collapse: collapse; font-size: 0.8rem; display: block; overflow-x: auto; }
th, td { padding: 0.2rem 0.6rem; text-align: left; border-bottom: 1px solid #ddd; white-space: nowrap; }
th { border-bottom-color: #222; }
pre { background: #f5f5f5; padding: 0.6rem; overflow-x: auto; }
figure { margin: 1rem 0; } figure svg { max-width: 100%; height: auto; }
"""


@dataclass(frozen=True)
class Heading:
    """A title, of the page at level 1."""

    text: str
    level: int = 2


@dataclass(frozen=True)
class Words:
    """A paragraph."""

    text: str


@dataclass(frozen=True)
class Bullets:
    """Sentences one by one."""

    texts: Sequence[str]


@dataclass(frozen=True)
class Code:
    """A command line."""

    text: str


@dataclass(frozen=True)
class Cells:
    """A table."""

    heads: Sequence[str]
    rows: Sequence[Sequence[str]]


@dataclass(frozen=True)
class Picture:
    """A figure, the name of its file where it has one, and what one sees."""

    name: str
    figure: Any
    shows: str


Block = Heading | Words | Bullets | Code | Cells | Picture


def pictures_of(page: Path) -> Path:
    """The folder of a Markdown page's pictures."""
    return page.with_suffix("")


def write_page(page: Path, blocks: Sequence[Block]) -> None:
    """The page whole, under a temporary name first; pictures of Markdown go into a folder of the page's name."""
    partial = page.with_name(f"{page.name}.partial")
    try:
        if page.suffix == ".html":
            partial.write_text(_html(blocks), encoding="utf-8")
        else:
            _save_pictures(pictures_of(page), [block for block in blocks if isinstance(block, Picture)])
            partial.write_text(_markdown(page, blocks), encoding="utf-8")
        partial.rename(page)
    except OSError as error:
        raise UserError(f"{page} can't be written ({error.strerror}); name another page.") from None


def _save_pictures(folder: Path, pictures: Sequence[Picture]) -> None:
    partial = folder.with_name(f"{folder.name}.partial")
    shutil.rmtree(partial, ignore_errors=True)
    partial.mkdir()
    for picture in pictures:
        save(picture.figure, partial / f"{picture.name}.png")
    partial.rename(folder)


def _markdown(page: Path, blocks: Sequence[Block]) -> str:
    return "\n\n".join(_as_markdown(block, pictures_of(page).name) for block in blocks) + "\n"


def _as_markdown(block: Block, pictures: str) -> str:
    match block:
        case Heading(text, level):
            return f"{'#' * level} {text}"
        case Words(text):
            return _flow(text)
        case Bullets(texts):
            return "\n".join(_flow(f"- {text}", indent="  ") for text in texts)
        case Code(text):
            return f"```\n{text}\n```"
        case Cells(heads, rows):
            lines = [heads, ["---"] * len(heads), *rows]
            return "\n".join(f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in line)} |" for line in lines)
        case Picture(name, _, shows):
            return f"![{shows}]({pictures}/{name}.png)"


def _flow(text: str, indent: str = "") -> str:
    """In lines of 120 characters."""
    return fill(text, 120, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False)


def _html(blocks: Sequence[Block]) -> str:
    title = next((escape(block.text) for block in blocks if isinstance(block, Heading)), "")
    body = "\n".join(map(_as_html, blocks))
    return (
        f'<!DOCTYPE html>\n<html lang="en">\n<head><meta charset="utf-8"><title>{title}</title>'
        f"<style>{_LOOK}</style></head>\n<body>\n{body}\n</body>\n</html>\n"
    )


def _as_html(block: Block) -> str:
    match block:
        case Heading(text, level):
            return f"<h{level}>{escape(text)}</h{level}>"
        case Words(text):
            return f"<p>{escape(text)}</p>"
        case Bullets(texts):
            return "<ul>" + "".join(f"<li>{escape(text)}</li>" for text in texts) + "</ul>"
        case Code(text):
            return f"<pre>{escape(text)}</pre>"
        case Cells(heads, rows):
            body = "".join(_row("td", cells) for cells in rows)
            return f"<table><thead>{_row('th', heads)}</thead><tbody>{body}</tbody></table>"
        case Picture(_, figure, shows):
            return f'<figure role="img" aria-label="{escape(shows)}">{_svg(figure)}</figure>'


def _row(tag: str, cells: Sequence[str]) -> str:
    return "<tr>" + "".join(f"<{tag}>{escape(cell)}</{tag}>" for cell in cells) + "</tr>"


def _svg(figure: Any) -> str:
    """The figure as an element of its own, without the head of a file."""
    file = io.StringIO()
    with rc_context(style.SETTINGS):
        figure.savefig(file, format="svg")
    text = file.getvalue()
    return text[text.index("<svg") :]
