"""Whether the Jacobian of a problem may be stored."""

from __future__ import annotations

from typing import Any

from springopt.errors import NotServed
from springopt.problem import Problem

LARGEST_BYTES = 4e9
#: Copies of the Jacobian, and of the curvature, that are alive at once.
JACOBIANS, CURVATURES = 4, 5


def require_memory(name: str, problem: Problem) -> None:
    """Refuses a problem whose Jacobian, and the dense curvature made of it, take more than memory should hold."""
    needed = 8.0 * CURVATURES * problem.size**2
    if "objective" in problem.supplies:
        objective: Any = problem.objective
        training = sum(case.role == "train" for case in objective.cases)
        springs = objective.model.lattice.spring_count
        numbers = objective.reference_positions[0].size  # at all times
        needed += 8.0 * JACOBIANS * training * numbers * max(problem.size, springs)
    if needed > LARGEST_BYTES:
        raise NotServed(
            f"{name} would need some {needed / 1e9:.0f} GB of memory for its Jacobian, and stops at "
            f"{LARGEST_BYTES / 1e9:.0f}; use l-bfgs-b.",
            word="memory",
        )
