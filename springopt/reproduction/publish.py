"""The page and its pictures on disk: whole or not at all, and over nothing that is there."""

from __future__ import annotations

import shutil
from collections.abc import Iterable
from pathlib import Path

from springopt.errors import UserError
from springopt.report.figures import save
from springopt.reproduction.experiment import Picture

PAGE, PICTURES = "reproduction.md", "reproduction"


def require_new(out: Path) -> None:
    """Makes the folder of the page, and refuses one where a page or its pictures are."""
    for path in (out / PAGE, out / PICTURES):
        if path.exists():
            raise UserError(f"{path} exists already, and nothing is overwritten; move it away, or name another --out.")
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UserError(f"the folder {out} can't be made ({error.strerror}); name another --out.") from None


def publish(out: Path, text: str, pictures: Iterable[Picture]) -> Path:
    """Writes pictures and page under temporary names and renames them, the page last; its path."""
    partial, page = out / f"{PICTURES}.partial", out / f"{PAGE}.partial"
    shutil.rmtree(partial, ignore_errors=True)
    try:
        partial.mkdir()
        for picture in pictures:
            save(picture.figure, partial / f"{picture.name}.png")
        page.write_text(text, encoding="utf-8")
        partial.rename(out / PICTURES)
        return page.rename(out / PAGE)
    except OSError as error:
        raise UserError(
            f"the page can't be written in {out} ({error.strerror}); free the disk, then call reproduce again."
        ) from None
