"""What a forward solve says of itself."""

import enum

import numpy as np
from numpy.typing import NDArray


class Status(enum.StrEnum):
    """How the search for one equilibrium ended; only the first two come with an equilibrium."""

    CONVERGED = "converged"
    #: Converged, but some modes carry no load and no stiffness; they are kept at rest.
    UNDERDETERMINED = "underdetermined"
    #: The load works on a mode that nothing resists: no equilibrium exists.
    MECHANISM = "mechanism"
    #: A stationary point was found that is no minimum, and no way down from it.
    UNSTABLE = "unstable"
    ITERATION_LIMIT = "iteration limit"
    INVALID_INPUT = "invalid input"

    @property
    def has_equilibrium(self) -> bool:
        return self in (Status.CONVERGED, Status.UNDERDETERMINED)


STATUSES = np.array(list(Status), dtype=object)
# The codes that kernels and journals write: positions in the list above.
CONVERGED, UNDERDETERMINED, MECHANISM, UNSTABLE, ITERATION_LIMIT, INVALID_INPUT = range(len(Status))


def has_equilibrium(codes: NDArray[np.int8]) -> NDArray[np.bool_]:
    """Which of the status codes come with an equilibrium."""
    return codes <= UNDERDETERMINED
