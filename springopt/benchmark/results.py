"""Results to compare: run files, and what stands in for a run that could not be made."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from springopt.benchmark.record import Record, record_of
from springopt.benchmark.terms import on_equal_terms
from springopt.errors import RunFileError, UserError, did_you_mean
from springopt.journal import journal_path, run_path
from springopt.store import read_run


@dataclass(frozen=True)
class Refusal:
    """A method that can't serve a scene."""

    scene: str
    method: str
    word: str  #: the reason, for a table's cell
    sentence: str


@dataclass(frozen=True)
class LeftOut:
    """A run that is there, and not in the comparison."""

    path: str
    why: str


@dataclass(frozen=True)
class Results:
    """All that was found, by scene, method and seed."""

    records: list[Record]
    refusals: list[Refusal] = field(default_factory=list)
    left_out: list[LeftOut] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)  #: sentences that a reader must know

    @property
    def scenes(self) -> list[str]:
        return sorted({each.scene for each in self.records} | {each.scene for each in self.refusals})

    @property
    def methods(self) -> list[str]:
        return sorted({each.method for each in self.records} | {each.method for each in self.refusals})


def read_results(paths: Iterable[str | Path], *, optimizers: Sequence[str] = (), scenes: Sequence[str] = ()) -> Results:
    """Reads folders of results and run files.

    In `FOLDER/<scene>/<label>/seed<N>.h5` the label is the method's name; any other run file goes by its optimizer.

    Args:
        paths: folders, searched to their depth, and run files.
        optimizers, scenes: those to compare; by default all.
    """
    files = _files(paths)
    left_out = [LeftOut(str(file), _why_unfinished(file)) for file in files["unfinished"]]
    left_out += [LeftOut(str(file), _stated(file, "sentence")["sentence"]) for file in files["failed"]]
    records = []
    for file in files["runs"]:
        try:
            record = _read(file)
        except RunFileError as error:
            left_out.append(LeftOut(str(file), str(error)))
            continue
        if record is None:
            left_out.append(LeftOut(str(file), "interrupted; finish it with springopt solve --resume"))
        else:
            records.append(record)
    refusals = [_refusal(file) for file in files["refused"]]
    if not records:
        raise UserError(f"there is no complete run in {', '.join(map(str, paths))}; give a folder of results, or runs.")
    chosen = _chosen(Results(records, refusals, left_out), optimizers, scenes)
    records, notes = on_equal_terms(chosen.records)
    return replace(chosen, records=records, notes=notes)


def _files(paths: Iterable[str | Path]) -> dict[str, list[Path]]:
    """Runs, refusals, failures, and journals of runs that have no file yet; none of them twice."""
    patterns = {"runs": "*.h5", "refused": "refused.json", "failed": "*.failed.json", "unfinished": "*.h5.journal"}
    files: dict[str, dict[Path, Path]] = {kind: {} for kind in patterns}
    for path in map(Path, paths):
        if not path.exists():
            raise UserError(f"there is nothing at {path}; give a folder of results, or run files.")
        for kind, pattern in patterns.items():
            found = sorted(path.rglob(pattern)) if path.is_dir() else [path] * path.match(pattern)
            files[kind].update((file.resolve(), file) for file in found)
        if path.is_file() and not any(path.match(pattern) for pattern in patterns.values()):
            files["runs"][path.resolve()] = path  # whatever it is, reading it says so
    unfinished = {key: file for key, file in files["unfinished"].items() if not run_path(file).exists()}
    return {kind: list(found.values()) for kind, found in {**files, "unfinished": unfinished}.items()}


def _read(path: Path) -> Record | None:
    order, run = read_run(path)
    if not run.complete or journal_path(path).exists():
        return None
    in_place = path.absolute().parent.parent.name == run.scene
    return record_of(order, run, path, path.absolute().parent.name if in_place else run.method)


def _why_unfinished(journal: Path) -> str:
    return f"going on, or killed; finish it with springopt solve --resume {run_path(journal)}"


def _refusal(path: Path) -> Refusal:
    stated, place = _stated(path, "word", "sentence"), path.absolute().parent
    return Refusal(place.parent.name, place.name, stated["word"], stated["sentence"])


def _stated(path: Path, *names: str) -> dict[str, str]:
    """What a small JSON file says under these names."""
    try:
        stated = json.loads(path.read_text(encoding="utf-8"))
        return {name: str(stated[name]) for name in names}
    except (OSError, ValueError, KeyError, TypeError):
        raise UserError(f"{path} does not say {' and '.join(names)}; remove it, and run the benchmark again.") from None


def _chosen(found: Results, optimizers: Sequence[str], scenes: Sequence[str]) -> Results:
    """What the user named; a name that nothing has is a mistake."""
    _require_known("optimizer", optimizers, found.methods)
    _require_known("scene", scenes, found.scenes)

    def keep(each: Record | Refusal) -> bool:
        return (not optimizers or each.method in optimizers) and (not scenes or each.scene in scenes)

    records = [record for record in found.records if keep(record)]
    if not records:
        raise UserError("none of these optimizers has a run on these scenes; name others.")
    return replace(found, records=records, refusals=[refusal for refusal in found.refusals if keep(refusal)])


def _require_known(what: str, names: Sequence[str], known: Sequence[str]) -> None:
    for name in names:
        if name not in known:
            raise UserError(
                f"these results have no {what} {name!r}; name one of {', '.join(known)}.{did_you_mean(name, known)}"
            )
