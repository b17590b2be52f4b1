"""Comparisons: what runs of several optimizers say of them, on each scene and over scenes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from springopt.comparison.comparison import Comparison, compare

__all__ = ["Comparison", "compare"]


def __getattr__(name: str) -> Any:
    """Imports the statistics only when something is compared."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from springopt.comparison import comparison

    return getattr(comparison, name)
