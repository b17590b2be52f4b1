"""The forces of springs for small displacements, and what a change of stiffness does to them."""

from typing import Any

from springopt.effects.compile import compiled
from springopt.effects.springs import TINY


@compiled
def linear_spring_gradients(plan: Any, displacements: Any, adjoints: Any, answers: Any) -> None:
    """-adjoint . dF/dk of all springs into `answers` (c, s), `displacements` and `adjoints` (c, n d).

    Per stiffness, a spring along e with prestrain q = |D| - L0 pulls with q e + (e . du) e + q / |D| (du - (e . du) e).
    """
    d = plan.dimension
    for spring in range(len(plan.ends)):
        i, j = plan.ends[spring, 0] * d, plan.ends[spring, 1] * d
        length, natural = max(plan.lengths[spring], TINY), plan.natural_lengths[spring]
        transverse = 1.0 if natural == 0.0 else plan.prestrains[spring] / length
        for case in range(len(displacements)):
            along = 0.0
            for a in range(d):
                along += plan.rest_vectors[spring, a] * (displacements[case, j + a] - displacements[case, i + a])
            axial = (1.0 - transverse) * along / (length * length)
            total = 0.0
            for a in range(d):
                rest, du = plan.rest_vectors[spring, a], displacements[case, j + a] - displacements[case, i + a]
                force = transverse * (rest + du) + axial * rest
                total += (adjoints[case, i + a] - adjoints[case, j + a]) * force
            answers[case, spring] = total
