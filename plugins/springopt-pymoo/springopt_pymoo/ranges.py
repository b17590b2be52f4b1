"""Options in their ranges. Modules of optimizers import pymoo when they run: listing them is to stay quick."""

from __future__ import annotations

from typing import Any

from springopt.errors import UserError


def require_options(optimizer: Any, **ranges: tuple[float, float]) -> None:
    """Refuses an option outside its range; none, which stands for pymoo's default, is always inside."""
    for name, (lowest, highest) in ranges.items():
        number = getattr(optimizer, name)
        if number is not None and not lowest <= number <= highest:
            raise UserError(
                f"option {name} of {optimizer.name} lies in [{lowest:g}, {highest:g}], not at {number}; "
                "give another value."
            )
