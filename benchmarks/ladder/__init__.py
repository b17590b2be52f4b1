"""The stability ladder: rungs with a known right answer or refusal, family by family, and their independent judge."""

from ladder import (
    collapsed,
    contrasts,
    duplicates,
    hard,
    inputs,
    large_loads,
    mechanisms,
    pressed,
    snap_through,
    supports,
    topologies,
    unit_systems,
)
from ladder.rung import READINGS, RIGHT, RIGHTLY_REFUSED, SILENTLY_WRONG, WRONGLY_REFUSED, Rung, Verdict

FAMILIES = (
    contrasts,
    mechanisms,
    topologies,
    pressed,
    snap_through,
    collapsed,
    duplicates,
    large_loads,
    unit_systems,
    supports,
    inputs,
    hard,
)

__all__ = [
    "FAMILIES",
    "READINGS",
    "RIGHT",
    "RIGHTLY_REFUSED",
    "SILENTLY_WRONG",
    "WRONGLY_REFUSED",
    "Rung",
    "Verdict",
    "climb",
]


def climb() -> list[Verdict]:
    """Every rung's verdict."""
    return [rung.verdict() for family in FAMILIES for rung in family.rungs()]
