"""The build and the processor that a run is exact on."""

from __future__ import annotations

import hashlib
import platform
import re
from collections.abc import Mapping
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from springopt.errors import RunFileError
from springopt.optimizer import Optimizer
from springopt.registry import distribution_of

_LIBRARIES = ("springopt", "numpy", "scipy", "numba")
_BESIDE_THE_ANSWERS = ("analysis", "benchmark", "cli", "comparison", "report", "reproduction", "testing", "tradeoff")


def this_origin(optimizer: type[Optimizer], start: type[Optimizer] | None = None) -> dict[str, str]:
    """Versions of whatever takes part in the arithmetic, and the type of processor.

    Of springopt the sources count too, for one that is worked on. Of an optimizer they do not, so that a run which it
    broke goes on once it is mended: the questions on record tell whether it still does the same.
    """
    return {
        "python": ".".join(platform.python_version_tuple()[:2]),
        **{name: _version(name) for name in _LIBRARIES},
        "springopt's sources": _sources(),
        "the optimizer of": _distribution(optimizer),
        **({"the start of": _distribution(start)} if start else {}),
        "processor": processor(),
    }


def require_this_origin(
    origin: Mapping[str, str], what: str, optimizer: type[Optimizer], start: type[Optimizer] | None = None
) -> None:
    """Refuses to go on with what was made by another build or on another type of processor."""
    here = this_origin(optimizer, start)
    for name in here:
        if origin.get(name) != here[name]:
            raise RunFileError(
                f"{what} was made with {name} {origin.get(name, 'unknown')} and here it is {here[name]}, where answers "
                "need not be the same to the last bit; resume it there, or start a new run."
            )


def _distribution(optimizer: type[Optimizer]) -> str:
    distribution = distribution_of(optimizer)
    return f"{distribution.name} {distribution.version}" if distribution else "no distribution"


def _version(distribution: str) -> str:
    try:
        return version(distribution)
    except PackageNotFoundError:
        return "unknown"


@cache
def _sources() -> str:
    """A digest of all sources that an answer could depend on."""
    digest, package = hashlib.blake2b(digest_size=8), Path(__file__).parent
    for path in sorted(package.rglob("*.py")):
        place = path.relative_to(package)
        if place.parts[0] not in _BESIDE_THE_ANSWERS:
            digest.update(place.as_posix().encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()


def processor() -> str:
    """The processor: the model's name where the system tells it, else its architecture."""
    try:
        model = re.search(r"^model name\s*: (.+)$", Path("/proc/cpuinfo").read_text(), re.MULTILINE)
    except OSError:
        model = None
    return model[1] if model else platform.processor() or platform.machine()
