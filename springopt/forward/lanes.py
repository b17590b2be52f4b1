"""Many small systems: eight equilibria at a time in lanes, whatever candidate and load case they belong to."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from springopt.effects.compile import announce_compilation
from springopt.forward.engine import ITERATION_LIMIT
from springopt.forward.lane_factors import LaneFactors
from springopt.forward.newton import find_equilibria
from springopt.forward.plan import Plan
from springopt.forward.state import Answers, Jobs, make_lanes

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class LanesEngine:
    """One kernel call for all jobs."""

    plan: Plan

    def find(self, jobs: Jobs, answers: Answers, tolerance: float) -> None:
        """See `Engine`."""
        announce_compilation(find_equilibria)
        lanes = make_lanes(self.plan)
        find_equilibria(self.plan, jobs, lanes, answers, tolerance, ITERATION_LIMIT)

    def factorize(self, candidate: Floats, displacements: Floats) -> LaneFactors:
        """See `Engine`."""
        return LaneFactors.of(self.plan, candidate, displacements)
