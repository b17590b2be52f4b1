"""Optimizers that fail or refuse, as entry points of a distribution that is not installed."""

from dataclasses import dataclass
from importlib.metadata import EntryPoint, entry_points

from springopt import registry
from springopt.errors import NotServed
from springopt.optimizer import Optimizer


@dataclass(frozen=True)
class Rogue(Optimizer):
    """Asks for a few values and breaks."""

    name = "rogue"

    def minimize(self, problem, rng):
        problem.evaluate(problem.sample(rng, 3))
        raise ZeroDivisionError("out of luck")


@dataclass(frozen=True)
class Bits(Optimizer):
    """Needs bits."""

    name = "bits"
    needs = ("binary",)

    def minimize(self, problem, rng):
        problem.evaluate(problem.sample(rng, 1))


@dataclass(frozen=True)
class Shy(Optimizer):
    """Refuses when it is at work."""

    name = "shy"

    def minimize(self, problem, rng):
        raise NotServed("shy would need 9 GB of memory; choose another.", word="memory")


@dataclass(frozen=True)
class Middle(Optimizer):
    """Is content with the middle of the box."""

    name = "middle"

    def minimize(self, problem, rng):
        problem.evaluate([(problem.lower + problem.upper) / 2])


def install(monkeypatch, *names):
    """Leaves these optimizers, strange ones and installed ones, and no other."""
    strange = [
        EntryPoint(kind.name, f"{kind.__module__}:{kind.__name__}", registry.GROUP)
        for kind in (Rogue, Bits, Shy, Middle)
    ]

    def found(group):
        entries = entry_points(group=group)
        if group != registry.GROUP:
            return entries
        return [entry for entry in [*entries, *strange] if entry.name in names]

    monkeypatch.setattr(registry, "entry_points", found)
