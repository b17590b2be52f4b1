"""Files of results: runs, and what lies where a run could not be made."""

from __future__ import annotations

import json
import re
from collections.abc import Container, Iterable
from dataclasses import dataclass
from pathlib import Path

from springopt.benchmark.outcome import REFUSED
from springopt.errors import UserError
from springopt.journal import run_path

IN_PLACE = re.compile(rf"seed\d+\.|{re.escape(REFUSED)}$")  # names of files in a folder of results


@dataclass(frozen=True)
class ResultFile:
    """A file, and in a place as `<scene>/<label>/seed<N>.h5` whose it is by its place."""

    path: Path
    is_named: bool = False  #: by the user, and not found in a folder

    @property
    def scene(self) -> str | None:
        return self._place[0]

    @property
    def label(self) -> str | None:
        return self._place[1]

    @property
    def _place(self) -> tuple[str, str] | tuple[None, None]:
        label = self.path.absolute().parent
        in_place = IN_PLACE.match(self.path.name) and not self.is_named
        return (label.parent.name, label.name) if in_place else (None, None)

    def may_be_of(self, scenes: Container[str | None], labels: Container[str | None]) -> bool:
        """Whether it can belong to one of these; of a file in no such place only reading it tells."""
        return self.scene is None or (self.scene in scenes and self.label in labels)

    def says(self, *names: str) -> dict[str, str]:
        """What a small JSON file has under these names."""
        try:
            stated = json.loads(self.path.read_text(encoding="utf-8"))
            return {name: str(stated[name]) for name in names}
        except (OSError, ValueError, KeyError, TypeError):
            what = " and ".join(names)
            raise UserError(f"{self.path} does not say its {what}; remove it, and run the benchmark again.") from None


@dataclass(frozen=True)
class ResultFiles:
    """All that was found, each file once."""

    runs: list[ResultFile]
    refusals: list[ResultFile]
    failures: list[ResultFile]
    journals: list[ResultFile]  #: of runs that have no file yet

    def of(self, scenes: Container[str | None], labels: Container[str | None]) -> ResultFiles:
        """Those that can belong to these scenes and labels."""
        kinds = self.runs, self.refusals, self.failures, self.journals
        return ResultFiles(*([file for file in files if file.may_be_of(scenes, labels)] for files in kinds))

    @property
    def scenes(self) -> set[str]:
        return {file.scene for file in [*self.runs, *self.refusals, *self.failures] if file.scene is not None}

    @property
    def labels(self) -> set[str]:
        return {file.label for file in [*self.runs, *self.refusals, *self.failures] if file.label is not None}


def find_results(paths: Iterable[str | Path]) -> ResultFiles:
    """Searches folders to their depth; a file that is named is a run, whatever it is called."""
    found: dict[str, dict[Path, ResultFile]] = {"*.h5": {}, REFUSED: {}, "*.failed.json": {}, "*.h5.journal": {}}
    for path in map(Path, paths):
        if not path.exists():
            raise UserError(f"there is nothing at {path}; give a folder of results, or run files.")
        if path.is_file():
            found["*.h5"].setdefault(path.resolve(), ResultFile(path, is_named=True))
            continue
        for pattern, files in found.items():
            for file in sorted(path.rglob(pattern)):
                files.setdefault(file.resolve(), ResultFile(file))
    runs, refusals, failures, journals = (list(files.values()) for files in found.values())
    return ResultFiles(runs, refusals, failures, [file for file in journals if not run_path(file.path).exists()])
