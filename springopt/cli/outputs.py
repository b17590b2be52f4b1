"""Files that commands write: never over one that exists, and refused before any work."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

from springopt.errors import UserError

FIGURE_ENDINGS = (".png", ".pdf", ".svg")
ARRAY_ENDINGS = (".npz",)
TABLE_ENDINGS = (".csv",)
PAGE_ENDINGS = (".html", ".md")


def require_new_folder(path: str) -> Path:
    """The path of a folder that does not exist yet and can be made, or is empty."""
    folder = Path(path)
    if folder.is_dir() and not any(folder.iterdir()):
        return folder
    if folder.exists():
        raise UserError(f"{path} exists already, and nothing is overwritten; name another folder.")
    _require_possible(folder)
    return folder


def _require_possible(folder: Path) -> None:
    """Makes the folder and takes it away again: what a file system allows, only trying tells."""
    missing = [each for each in (folder, *folder.parents) if not each.exists()]
    try:
        folder.mkdir(parents=True)
    except OSError as error:
        raise UserError(f"{folder} can't be made ({error.strerror}); name another folder.") from None
    finally:
        for each in missing:
            with suppress(OSError):
                each.rmdir()


def require_new(path: str, endings: tuple[str, ...]) -> Path:
    """The path, if it has one of the endings, its folder exists and nothing is there yet."""
    output = Path(path)
    if output.suffix.lower() not in endings:
        raise UserError(f"an output here ends in {' or '.join(endings)}, not as {path}; name another file.")
    if not output.parent.is_dir():
        raise UserError(f"the folder of {path} does not exist; make it, or name another file.")
    if output.exists():
        raise UserError(f"{path} exists already, and nothing is overwritten; name another file.")
    return output


def require_new_page(path: str) -> Path:
    """The path of a page; where it is Markdown, nothing may be where its folder of pictures comes, either."""
    page = require_new(path, PAGE_ENDINGS)
    pictures = page.with_suffix("")
    if page.suffix.lower() == ".md" and pictures.exists():
        raise UserError(f"{pictures}, where the pictures would be, exists already; name another page.")
    return page
