"""Who takes part: the installed optimizers that a scene supplies, made ready and warm; and who does not, and why."""

from __future__ import annotations

import time
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from springopt.budget import Budget
from springopt.errors import NotServed, UserError
from springopt.optimizer import NEEDS, Optimizer, require_supplies
from springopt.options import make_optimizer
from springopt.problem import Problem
from springopt.registry import optimizers
from springopt.rehearsal import rehearse
from springopt.scene import Setup
from springopt.tradeoff.clock import Progress


@dataclass(frozen=True)
class Entrant:
    """An optimizer with the scene's options, whose imports and kernels are paid for."""

    optimizer: Optimizer
    warm_up: float  #: seconds on the wall

    @property
    def name(self) -> str:
        return self.optimizer.name


def entrants_of(
    setup: Setup, wanted: Iterable[str] = (), progress: Progress | None = None
) -> tuple[list[Entrant], dict[str, str]]:
    """Those of these names, or all that are installed; and why others can't serve, by name."""
    names, entrants = set(wanted), []
    ready, refused = _ready(setup, names)
    for number, optimizer in enumerate(ready):
        begun = time.perf_counter()
        rehearse(optimizer, setup)
        entrants.append(Entrant(optimizer, time.perf_counter() - begun))
        if progress:
            progress(number + 1, len(ready), f"warm-up: {optimizer.name}")
    return entrants, refused


def say_refused(refused: Mapping[str, str]) -> list[str]:
    """One sentence for all that can't serve, those with the same reason together; none if all can."""
    names: dict[str, list[str]] = {}
    for name, why in sorted(refused.items()):
        names.setdefault(why, []).append(name)
    said = "; ".join(f"{', '.join(who)}, because of {why}" for why, who in names.items())
    return [f"Left out: {said}."] if said else []


def reason(refusal: NotServed) -> str:
    """As in "the lack of a real encoding"."""
    return f"the lack of {NEEDS[refusal.word]}" if refusal.word in NEEDS else f"its {refusal.word}"


def _ready(setup: Setup, wanted: set[str]) -> tuple[list[Optimizer], dict[str, str]]:
    supplies = Problem(setup.objective, setup.encoding, Budget(evaluations=1)).supplies
    ready, refused = [], {}
    for name, kind in optimizers().items():
        if wanted and name not in wanted:
            continue
        try:
            optimizer = make_optimizer(kind, setup.scene.optimizer_options(name))
            require_supplies(optimizer, supplies)
        except NotServed as refusal:
            refused[name] = reason(refusal)
        except UserError as error:
            refused[name] = f"this: {error}".rstrip(".")
        else:
            ready.append(optimizer)
    return ready, refused
