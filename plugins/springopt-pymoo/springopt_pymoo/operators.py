"""pymoo's operators for the two kinds of box, with the options that they have."""

from __future__ import annotations

from typing import Any

from pymoo.operators.crossover.pntx import TwoPointCrossover
from pymoo.operators.crossover.sbx import SBX
from pymoo.operators.mutation.bitflip import BitflipMutation
from pymoo.operators.mutation.pm import PM


def real_operators(crossover_eta: float, mutation_eta: float) -> dict[str, Any]:
    """Simulated binary crossover and polynomial mutation, Deb and Agrawal (1995), Deb and Goyal (1996)."""
    return {"crossover": SBX(eta=crossover_eta), "mutation": PM(eta=mutation_eta)}


def binary_operators() -> dict[str, Any]:
    """Two-point crossover, and flips that meet one bit of a child in the mean."""
    return {"crossover": TwoPointCrossover(), "mutation": BitflipMutation()}
