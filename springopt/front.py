"""The front of two goals, few springs and a low value: what can't be had better in one without losing in the other."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from springopt.checks import Floats, Integers


@dataclass(frozen=True, eq=False)
class Front:
    """Points that no other one beats, the fewest springs first: each further spring buys a lower value."""

    values: Floats = field(default_factory=lambda: np.empty(0))  #: of the objective, falling, shape (f,)
    springs: Integers = field(
        default_factory=lambda: np.empty(0, dtype=int)
    )  #: how many have a stiffness above 0, rising, shape (f,)
    points: Floats = field(default_factory=lambda: np.empty((0, 0)))  #: shape (f, size)

    def __len__(self) -> int:
        return len(self.values)

    def joined(self, values: Floats, springs: Integers, points: Floats) -> Front:
        """The front of these points and of m more; of two that are equal in both goals the earlier one stays."""
        all_values, all_springs = np.append(self.values, values), np.append(self.springs, springs)
        order = np.lexsort((all_values, all_springs))
        lowest_before = np.minimum.accumulate(np.append(np.inf, all_values[order]))[:-1]
        kept = order[all_values[order] < lowest_before]
        if np.array_equal(kept, np.arange(len(self))):
            return self
        rows = [*self.points, *points]
        return Front(all_values[kept], all_springs[kept], np.array([rows[i] for i in kept]))
