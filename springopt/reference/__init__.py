"""References: what the body does under a load case, for the model to learn."""

from typing import Protocol

from springopt.checks import Floats
from springopt.load_case import LoadCase


class Reference(Protocol):
    """Anything that knows the deformation to match."""

    def deform(self, case: LoadCase) -> Floats:
        """Positions of the nodes under the load case [length], shape (n, d), or (t, n, d) where it has times."""
        ...
