"""Run files named on the command line."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from springopt.errors import RunFileError

if TYPE_CHECKING:
    from springopt.store import RunFile


def require_no_folder(path: str) -> Path:
    """The path, unless a folder is there."""
    if Path(path).is_dir():
        raise RunFileError(f"{path} is a folder and no run file; give the path of RUN.h5.")
    return Path(path)


def names_run(source: str) -> bool:
    """Whether a SCENE|RUN.h5 of the command line is a run."""
    return source.endswith(".h5") or (not source.endswith(".toml") and Path(source).is_file())


def read_run(path: str) -> RunFile:
    """What a run file holds; of a run that was killed only the journal is there, and the error says what to do."""
    from springopt.journal import holds_run, journal_path
    from springopt.store import read

    file = require_no_folder(path)
    if not file.exists() and holds_run(journal_path(file)):
        raise RunFileError(
            f"{path} is not written yet: its run is going on, or was killed; "
            f"finish it with springopt solve --resume {path}."
        )
    return read(file)
