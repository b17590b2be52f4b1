"""Benchmarks: many runs of many optimizers on many scenes, in one folder of results."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from springopt.benchmark.execute import run_jobs
    from springopt.benchmark.job import Job, run_job
    from springopt.benchmark.outcome import Outcome
    from springopt.benchmark.same import same_result

__all__ = ["Job", "Outcome", "run_job", "run_jobs", "same_result"]

_HOMES = {"Job": "job", "Outcome": "outcome", "run_job": "job", "run_jobs": "execute", "same_result": "same"}


def __getattr__(name: str) -> Any:
    """Imports the numerics only when a job is made."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
