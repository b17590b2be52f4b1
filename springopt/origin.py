"""The build and the processor that a run is exact on."""

from __future__ import annotations

import platform
import re
from collections.abc import Mapping
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from springopt.errors import RunFileError

_LIBRARIES = ("springopt", "numpy", "scipy", "numba")


def this_origin() -> dict[str, str]:
    """Versions of whatever takes part in the arithmetic, and the type of processor."""
    python = ".".join(platform.python_version_tuple()[:2])
    return {"python": python, **{name: _version(name) for name in _LIBRARIES}, "processor": _processor()}


def require_this_origin(origin: Mapping[str, str], what: str) -> None:
    """Refuses to go on with what was made by another build or on another type of processor."""
    here = this_origin()
    for name in here:
        if origin.get(name) != here[name]:
            raise RunFileError(
                f"{what} was made with {name} {origin.get(name, 'unknown')} and here it is {here[name]}, where answers "
                "need not be the same to the last bit; resume it there, or start a new run."
            )


def _version(distribution: str) -> str:
    try:
        return version(distribution)
    except PackageNotFoundError:
        return "unknown"


def _processor() -> str:
    """The model's name where the system tells it, else its architecture."""
    try:
        model = re.search(r"^model name\s*: (.+)$", Path("/proc/cpuinfo").read_text(), re.MULTILINE)
    except OSError:
        model = None
    return model[1] if model else platform.processor() or platform.machine()
