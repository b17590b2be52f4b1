"""Compiled once, kept on disk: where kernels are cached, and the line that says when one is compiled.

numba notices changes in a kernel's own file only, not in those it calls, and wants to write beside the sources. So the
cache lives in the user's cache folder, in a folder named by the contents of all kernel sources. NUMBA_CACHE_DIR wins.
"""

import hashlib
import logging
import os
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

import numba
from platformdirs import user_cache_path

_LOG = logging.getLogger("springopt")


def compiled(function: Callable[..., Any]) -> Any:
    """`numba.njit` without the interpreter lock, cached on disk."""
    with _cached():
        return numba.njit(error_model="numpy", nogil=True, cache=True)(function)


def kernel(function: Callable[..., Any]) -> Any:
    """A C function of an effect's KERNEL_SIGNATURE, cached on disk."""
    from springopt.effects.effect import KERNEL_SIGNATURE

    with _cached():
        return numba.cfunc(KERNEL_SIGNATURE, cache=True, error_model="numpy")(function)


@contextmanager
def _cached() -> Iterator[None]:
    before = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = before or str(cache_folder())
    try:
        yield
    finally:
        numba.config.CACHE_DIR = before


@cache
def announce_compilation(kernel: Any) -> None:
    """Say so, once a process, if the next call of this kernel will compile it."""
    if kernel.signatures or _is_cached(kernel):
        return
    _LOG.warning("Compiling %s for this processor; this happens once and takes some 20 seconds.", kernel.__name__)


def _is_cached(kernel: Any) -> bool:
    folder = Path(kernel.stats.cache_path)
    return any(folder.glob(f"*{kernel.__name__}-*.nbi"))


@cache
def cache_folder() -> Path:
    """The user's cache folder, or a temporary one where that can't be written."""
    digest = hashlib.blake2b(digest_size=8)
    for room in ("effects", "forward"):
        for path in sorted((Path(__file__).parent.parent / room).rglob("*.py")):
            digest.update(path.read_bytes())
    name = f"kernels-{digest.hexdigest()}"
    for parent in (user_cache_path("springopt"), Path(tempfile.gettempdir()) / f"springopt-{_owner()}"):
        try:
            (parent / name).mkdir(parents=True, exist_ok=True)
        except OSError:
            continue
        if os.access(parent / name, os.W_OK):
            return parent / name
    return Path(tempfile.mkdtemp(prefix="springopt-"))


def _owner() -> str:
    return str(os.getuid()) if hasattr(os, "getuid") else "user"
