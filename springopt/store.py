"""The run file: everything about a run in one HDF5 file, written whole."""

from __future__ import annotations

import contextlib
import io
import json
import os
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from springopt.checks import Floats
from springopt.errors import RunFileError
from springopt.front import Front
from springopt.lattice import SpringLattice
from springopt.load_case import LoadCase
from springopt.recorder import Answer
from springopt.run import Improvement, LooseSelections, Order, Run

FORMAT = 2

_MARK = "springopt run"
_ARRAYS = ("stiffness", "point")
_PARAMETERS = ("parameters", "parameter_intervals", "reference_parameters")
_BLOBS = ("question", "payload", "checksum")


@dataclass(frozen=True, kw_only=True, eq=False)
class RunFile:
    """What a run file holds beside the answers; it needs no scene file to be shown."""

    order: Order
    run: Run
    lattice: SpringLattice
    cases: list[LoadCase]
    reference_positions: Floats  #: [length], shape (c, n, d), or (c, t, n, d) where cases have times
    positions: Floats  #: of the best candidate [length], as those of the reference


def write(path: Path, contents: RunFile, answers: Iterable[Answer]) -> None:
    """Writes a run file under a temporary name and renames it, so that at no time there is half a file.

    It may take the place of an earlier state of the same run, and of nothing else.
    """
    require_same_run(path, contents.order)
    partial = path.with_name(path.name + ".partial")
    try:
        with partial.open("wb") as file:
            file.write(_image(contents, list(answers)))
            file.flush()
            os.fsync(file.fileno())
        partial.replace(path)
        _sync_folder(path.parent)
    except OSError as error:
        partial.unlink(missing_ok=True)
        raise RunFileError(
            f"{path} can't be written ({error.strerror}); its journal holds the run: free the disk, then resume it."
        ) from None


def read(path: Path) -> RunFile:
    """What a run file holds; raises RunFileError if it is missing, foreign, damaged or of a newer format."""
    with _open(path) as file:
        return RunFile(
            order=Order.from_json(file["order"].asstr()[()]),
            run=_read_run(file, path),
            lattice=_read_lattice(file["lattice"]),
            cases=_read_cases(file["cases"]),
            reference_positions=file["reference_positions"][()],
            positions=file["positions"][()],
        )


def read_run(path: Path) -> tuple[Order, Run]:
    """What a run was asked and what came of it, and nothing else of its file: for those who read thousands."""
    with _open(path) as file:
        return Order.from_json(file["order"].asstr()[()]), _read_run(file, path)


def read_answers(path: Path) -> list[Answer]:
    """The answers of a run file, in order."""
    with _open(path) as file:
        columns = {name: _read_column(file["answers"][name]) for name in Answer._fields}
    columns["kind"] = [kind.decode() for kind in columns["kind"]]
    columns["value"] = [None if np.isnan(value) else value for value in columns["value"]]
    return [Answer(*row) for row in zip(*columns.values(), strict=True)]


def require_same_run(path: Path, order: Order) -> None:
    """Refuses to overwrite anything but an earlier state of the run with this order."""
    if path.exists() and read(path).order.to_json() != order.to_json():
        raise RunFileError(f"{path} holds another run than its journal; move one of the two away, then resume.")


def _image(contents: RunFile, answers: list[Answer]) -> memoryview:
    """The bytes of a run file; made in memory, because HDF5 does not survive a full disk."""
    image = io.BytesIO()
    with h5py.File(image, "w") as file:
        file.attrs["format"], file.attrs["version"] = _MARK, FORMAT
        file["order"] = contents.order.to_json()
        _write_run(file, contents.run)
        _write_lattice(file.create_group("lattice"), contents.lattice)
        _write_cases(file.create_group("cases"), contents.cases)
        file["reference_positions"] = contents.reference_positions
        file["positions"] = contents.positions
        _write_answers(file.create_group("answers"), answers)
    return image.getbuffer()


def _write_run(file: h5py.File, run: Run) -> None:
    facts = asdict(run)
    for name in _ARRAYS:
        file[name] = facts.pop(name)
    history = np.array(facts.pop("history"), dtype=float).reshape(-1, len(Improvement._fields))
    for name, column in zip(Improvement._fields, history.T, strict=True):
        file[f"history/{name}"] = column
    for name, curve in facts.pop("notes").items():
        file.create_dataset(f"notes/{name}", data=np.array(curve), compression="gzip")
    for name, column in facts.pop("front").items():
        file[f"front/{name}"] = column
    for name in (*_PARAMETERS, "loose_selections"):  # a run without is a file as it was before there were any
        if not facts[name]:
            del facts[name]
    file["run"] = json.dumps(facts)


def _read_run(file: h5py.File, path: Path) -> Run:
    facts = json.loads(file["run"].asstr()[()])
    facts |= {name: file[name][()] for name in _ARRAYS}
    if "loose_selections" in facts:
        facts["loose_selections"] = LooseSelections(*facts["loose_selections"])
    notes = {name: _curve(dataset) for name, dataset in file.get("notes", {}).items()}
    front = Front(**{name: column[()] for name, column in file.get("front", {}).items()})
    return Run(**facts | {"run": str(path)}, history=_read_history(file["history"]), notes=notes, front=front)


def _read_history(group: h5py.Group) -> list[Improvement]:
    rows = zip(*(group[name][()].tolist() for name in Improvement._fields), strict=True)
    return [Improvement(int(evaluations), int(solves), *rest) for evaluations, solves, *rest in rows]


def _curve(dataset: h5py.Dataset) -> list[tuple[int, float]]:
    return [(int(evaluations), value) for evaluations, value in dataset[()].tolist()]


def _write_lattice(group: h5py.Group, lattice: SpringLattice) -> None:
    group["nodes"], group["springs"], group["rest_lengths"] = lattice.nodes, lattice.springs, lattice.rest_lengths
    if lattice.cells is not None:
        group["cells"] = lattice.cells
        group.attrs["cell_type"] = lattice.cell_type


def _read_lattice(group: h5py.Group) -> SpringLattice:
    return SpringLattice(
        nodes=group["nodes"][()],
        springs=group["springs"][()],
        rest_lengths=group["rest_lengths"][()],
        cells=group["cells"][()] if "cells" in group else None,
        cell_type=group.attrs.get("cell_type"),
    )


def _write_cases(group: h5py.Group, cases: Sequence[LoadCase]) -> None:
    group["name"] = json.dumps([case.name for case in cases])  # HDF5's own text may have no NUL in it
    for name in ("role", "supports", "forces", "prescribed"):
        group[name] = [getattr(case, name) for case in cases]
    if cases and cases[0].times is not None:
        group["times"] = [case.times for case in cases]


def _read_cases(group: h5py.Group) -> list[LoadCase]:
    names, roles = json.loads(group["name"].asstr()[()]), group["role"].asstr()[()]
    arrays = zip(group["supports"][()], group["forces"][()], group["prescribed"][()], strict=True)
    cases = [LoadCase(name, *rest, role=role) for name, role, rest in zip(names, roles, arrays, strict=True)]
    times = group["times"][()] if "times" in group else [None] * len(cases)
    return [replace(case, times=own) for case, own in zip(cases, times, strict=True)]


def _write_answers(group: h5py.Group, answers: list[Answer]) -> None:
    columns: dict[str, Any] = dict(zip(Answer._fields, zip(*answers, strict=True), strict=True))
    for name in _BLOBS:
        _pack(group.create_group(name), columns.pop(name))
    columns["kind"] = [kind.encode() for kind in columns["kind"]]
    columns["value"] = [np.nan if value is None else value for value in columns["value"]]
    for name, column in columns.items():
        group.create_dataset(name, data=np.array(column), compression="gzip")


def _read_column(column: h5py.Group | h5py.Dataset) -> list[Any]:
    return _unpack(column) if isinstance(column, h5py.Group) else column[()].tolist()


def _pack(group: h5py.Group, blobs: Sequence[bytes | None]) -> None:
    """Bytes of different lengths as one array of bytes and the lengths, -1 where there is nothing."""
    group.create_dataset("lengths", data=[-1 if blob is None else len(blob) for blob in blobs], compression="gzip")
    group["bytes"] = np.frombuffer(b"".join(blob or b"" for blob in blobs), dtype=np.uint8)


def _unpack(group: h5py.Group) -> list[bytes | None]:
    lengths, joined = group["lengths"][()], group["bytes"][()].tobytes()
    ends = np.cumsum(np.maximum(lengths, 0)).tolist()
    return [
        None if length < 0 else joined[end - length : end] for length, end in zip(lengths.tolist(), ends, strict=True)
    ]


@contextmanager
def _open(path: Path) -> Iterator[h5py.File]:
    if not path.is_file():
        raise RunFileError(f"there is no run file {path}; give the path of RUN.h5.")
    if not h5py.is_hdf5(path):
        raise RunFileError(f"{path} is no run file of springopt; give the path of RUN.h5.")
    try:
        with h5py.File(path) as file:
            _require_format(path, file)
            yield file
    except (OSError, KeyError, ValueError, TypeError, RuntimeError) as error:
        if isinstance(error, RunFileError):
            raise
        raise RunFileError(f"{path} is damaged ({error}); start a new run.") from None


def _require_format(path: Path, file: h5py.File) -> None:
    if file.attrs.get("format") != _MARK:
        raise RunFileError(f"{path} is an HDF5 file, but no run file of springopt; give the path of RUN.h5.")
    if (made := int(file.attrs["version"])) != FORMAT:
        which = "a newer" if made > FORMAT else "the older"
        raise RunFileError(
            f"{path} has run file format {made}, and this springopt reads {FORMAT}; use {which} springopt."
        )


def _sync_folder(folder: Path) -> None:
    """Has a new name on the disk, not only the file behind it, where the system can."""
    with contextlib.suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY)
        os.fsync(descriptor)
        os.close(descriptor)
