"""Plugins that are installed: each distribution names its own in the entry point group of their kind.

Optimizers are in the group `springopt.optimizers`, effects in `springopt.effects`.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import Distribution, EntryPoint, entry_points
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from springopt.errors import PluginError, did_you_mean
from springopt.optimizer import Optimizer
from springopt.option_types import describe_type
from springopt.options import Option, declared_options, options_of

if TYPE_CHECKING:
    from springopt.effects.effect import Effect

GROUP = "springopt.optimizers"
EFFECT_GROUP = "springopt.effects"
Plugin = TypeVar("Plugin")


def optimizers() -> dict[str, type[Optimizer]]:
    """Every installed optimizer by name; one that can't be loaded is left out, with a warning that says why."""
    return _OPTIMIZERS.load_all()


def installed() -> list[str]:
    """The names of all installed optimizers, none of which is imported."""
    return list(_OPTIMIZERS.entries())


def load_optimizer(name: str) -> type[Optimizer]:
    """The optimizer of this name; no other plugin is imported.

    Raises PluginError if there is none, or if it can't be loaded.
    """
    return _OPTIMIZERS.load(name)


def effects() -> dict[str, type[Effect]]:
    """Every installed effect by name; one that can't be loaded is left out, with a warning that says why."""
    return _EFFECTS.load_all()


def installed_effects() -> list[str]:
    """The names of all installed effects, none of which is imported."""
    return list(_EFFECTS.entries())


def load_effect(name: str) -> type[Effect]:
    """The effect of this name; no other plugin is imported.

    Raises PluginError if there is none, or if it can't be loaded.
    """
    return _EFFECTS.load(name)


def distribution_of(plugin: type[Optimizer] | type[Effect]) -> Distribution | None:
    """The distribution that brings an optimizer or an effect; None if it is not installed as a plugin."""
    value = f"{plugin.__module__}:{plugin.__qualname__}"
    entries = (entry for group in (GROUP, EFFECT_GROUP) for entry in entry_points(group=group))
    return next((e.dist for e in entries if e.dist and (e.name, e.value) == (plugin.name, value)), None)


@dataclass(frozen=True)
class _Registry(Generic[Plugin]):
    """The plugins of one kind."""

    noun: str
    group: str
    base: Callable[[], type[Plugin]]  #: imported when the first plugin is
    options_of: Callable[[type[Plugin]], tuple[Option, ...]]  #: raises PluginError for one that may not be

    def entries(self) -> dict[str, EntryPoint]:
        """Entry points by name; of two distributions with one name the first in the alphabet has it."""
        last_wins = sorted(entry_points(group=self.group), key=_distribution, reverse=True)
        return dict(sorted({entry.name: entry for entry in last_wins}.items()))

    def load_all(self) -> dict[str, type[Plugin]]:
        found = {}
        for name, entry in self.entries().items():
            try:
                found[name] = self._load(entry)
            except PluginError as error:
                warnings.warn(str(error), RuntimeWarning, stacklevel=3)
        return found

    def load(self, name: str) -> type[Plugin]:
        entries = self.entries()
        if name not in entries:
            installed = ", ".join(entries) or "none"
            hint = did_you_mean(name, entries)
            raise PluginError(f"there is no {self.noun} {name!r}; installed: {installed}.{hint}")
        return self._load(entries[name])

    def _load(self, entry: EntryPoint) -> type[Plugin]:
        try:
            plugin = entry.load()
        except Exception as error:  # a stranger's module may raise anything while it is imported
            raise PluginError(
                f"{self.noun} {entry.name} of {_distribution(entry)} can't be loaded "
                f"({type(error).__name__}: {error}); mend or uninstall that distribution."
            ) from error
        base: Any = self.base()
        if not (isinstance(plugin, type) and issubclass(plugin, base) and getattr(plugin, "name", None) == entry.name):
            raise PluginError(
                f"{entry.value} of {_distribution(entry)} is no {base.__name__} with the name {entry.name!r}, "
                "as its entry point says; mend or uninstall that distribution."
            )
        self._require_options(entry, plugin)
        return plugin

    def _require_options(self, entry: EntryPoint, plugin: type[Plugin]) -> None:
        """Refuses a plugin whose options can't be told."""
        try:
            for option in self.options_of(plugin):
                describe_type(option.type)
        except Exception as error:  # annotations and default factories are a stranger's code too
            raise PluginError(
                f"{self.noun} {entry.name} of {_distribution(entry)} states an illegal option "
                f"({type(error).__name__}: {error}); mend or uninstall that distribution."
            ) from error


def effect_options(effect: type[Effect]) -> tuple[Option, ...]:
    """The options of an effect, which are the keys of its table in a scene; those without a default are required."""
    options = declared_options(effect)
    if "kind" in {option.name for option in options}:
        raise PluginError("an option can't be called kind, by which scenes tell effects apart; give it another name.")
    return options


def _effect() -> type[Effect]:
    """Imported where an effect is, because it brings numba."""
    from springopt.effects.effect import Effect

    return Effect


_OPTIMIZERS = _Registry("optimizer", GROUP, lambda: Optimizer, options_of)
_EFFECTS = _Registry("effect", EFFECT_GROUP, _effect, effect_options)


def _distribution(entry: EntryPoint) -> str:
    return entry.dist.name if entry.dist else "an unknown distribution"
