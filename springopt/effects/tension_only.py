"""Tension only: springs that go slack, as cables do."""

from dataclasses import dataclass
from typing import Any

from springopt.effects.effect import NOT_FITTED, Effect, Kernel
from springopt.effects.spring_law import law_kernel
from springopt.lattice import SpringLattice


@dataclass(frozen=True)
class TensionOnly(Effect):
    """No spring carries compression: the tension is k (L - L0) where L > L0, and else nothing.

    At L = L0 the stiffness is still that of tension.
    """

    name = "tension-only"
    scales_with_stiffness = True
    has_expansion_at_rest = False

    def potential(self, lattice: SpringLattice, fitted: frozenset[str] = NOT_FITTED) -> Kernel | None:
        return law_kernel(_kernel(), lattice)


def _kernel() -> Any:
    from springopt.effects.tension_only_kernel import take_compression_off

    return take_compression_off
