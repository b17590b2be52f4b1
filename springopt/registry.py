"""Optimizers that are installed: each distribution names its own in the entry point group `springopt.optimizers`."""

from __future__ import annotations

import warnings
from importlib.metadata import Distribution, EntryPoint, entry_points

from springopt.errors import PluginError, did_you_mean
from springopt.optimizer import Optimizer
from springopt.option_types import describe_type
from springopt.options import options_of

GROUP = "springopt.optimizers"


def optimizers() -> dict[str, type[Optimizer]]:
    """Every installed optimizer by name; one that can't be loaded is left out, with a warning that says why."""
    found = {}
    for name, entry in _entries().items():
        try:
            found[name] = _load(entry)
        except PluginError as error:
            warnings.warn(str(error), RuntimeWarning, stacklevel=2)
    return found


def installed() -> list[str]:
    """The names of all installed optimizers, none of which is imported."""
    return list(_entries())


def load_optimizer(name: str) -> type[Optimizer]:
    """The optimizer of this name; no other plugin is imported.

    Raises PluginError if there is none, or if it can't be loaded.
    """
    entries = _entries()
    if name not in entries:
        installed = ", ".join(entries) or "none"
        raise PluginError(f"there is no optimizer {name!r}; installed: {installed}.{did_you_mean(name, entries)}")
    return _load(entries[name])


def distribution_of(optimizer: type[Optimizer]) -> Distribution | None:
    """The distribution that brings an optimizer; None if it is not installed as a plugin."""
    value = f"{optimizer.__module__}:{optimizer.__qualname__}"
    entries = (entry for entry in entry_points(group=GROUP) if (entry.name, entry.value) == (optimizer.name, value))
    return next((entry.dist for entry in entries if entry.dist), None)


def _entries() -> dict[str, EntryPoint]:
    """Entry points by name; of two distributions with one name the first in the alphabet has it."""
    last_wins = sorted(entry_points(group=GROUP), key=_distribution, reverse=True)
    return dict(sorted({entry.name: entry for entry in last_wins}.items()))


def _load(entry: EntryPoint) -> type[Optimizer]:
    try:
        optimizer = entry.load()
    except Exception as error:  # a stranger's module may raise anything while it is imported
        raise PluginError(
            f"optimizer {entry.name} of {_distribution(entry)} can't be loaded ({type(error).__name__}: {error}); "
            "mend or uninstall that distribution."
        ) from error
    if not (isinstance(optimizer, type) and issubclass(optimizer, Optimizer) and optimizer.name == entry.name):
        raise PluginError(
            f"{entry.value} of {_distribution(entry)} is no Optimizer with the name {entry.name!r}, "
            "as its entry point says; mend or uninstall that distribution."
        )
    _require_options(entry, optimizer)
    return optimizer


def _require_options(entry: EntryPoint, optimizer: type[Optimizer]) -> None:
    """Refuses an optimizer whose options can't be told."""
    try:
        for option in options_of(optimizer):
            describe_type(option.type)
    except Exception as error:  # annotations and default factories are a stranger's code too
        raise PluginError(
            f"optimizer {entry.name} of {_distribution(entry)} states an illegal option "
            f"({type(error).__name__}: {error}); mend or uninstall that distribution."
        ) from error


def _distribution(entry: EntryPoint) -> str:
    return entry.dist.name if entry.dist else "an unknown distribution"
