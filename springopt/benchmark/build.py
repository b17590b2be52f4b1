"""The build of springopt, its libraries and an optimizer: where it is the same, so is what an optimizer does."""

from __future__ import annotations

from functools import lru_cache

from springopt.origin import this_origin
from springopt.registry import load_optimizer


@lru_cache
def build_of(optimizer: str) -> dict[str, str]:
    """The origin of a run without the type of processor, which is left to the user."""
    origin = this_origin(load_optimizer(optimizer))
    return {what: origin[what] for what in origin if what != "processor"}
