"""One load case: its own supports, prescribed displacements and nodal forces, and whether it trains or tests."""

from dataclasses import dataclass

import numpy as np

from springopt.checks import Booleans, Floats, booleans, floats, require_finite, require_positive, require_shape
from springopt.errors import UserError

ROLES = ("train", "test")


@dataclass(frozen=True, eq=False)
class LoadCase:
    """What is done to the body: where it is held, how it is moved, how it is pulled.

    A force on a support is legal: it enters the reaction only.
    """

    name: str
    supports: Booleans  #: which degrees of freedom are held, shape (n, d); (n,) holds all axes of a node
    forces: Floats  #: nodal forces [force], shape (n, d)
    #: Displacements of the supports [length], shape (n, d), zero elsewhere. Where the array given has nan entries, nan
    #: prescribes nothing, and every number makes its degree of freedom a support.
    prescribed: Floats = None  # type: ignore[assignment]
    role: str = "train"  #: "train" enters the objective, "test" is only reported
    #: When the motion is looked at [time], ascending from above 0, shape (t,): what is done to the body begins at time
    #: 0, suddenly, at rest, and lasts. Without times a load case is static.
    times: Floats | None = None

    def __post_init__(self) -> None:
        if self.role not in ROLES:
            raise UserError(f"The role of load case {self.name!r} must be 'train' or 'test', not {self.role!r}.")
        where = f"load case {self.name!r}:"
        forces = require_shape(f"{where} forces", floats(f"{where} forces", self.forces), ("n", "d"))
        supports = _supports(f"{where} supports", self.supports, forces.shape)
        if self.prescribed is None:
            prescribed = np.zeros(forces.shape)
        else:
            name = f"{where} prescribed"
            supports, prescribed = _prescribe(name, supports, floats(name, self.prescribed))
        object.__setattr__(self, "forces", require_finite(f"{where} forces", forces))
        object.__setattr__(self, "supports", supports)
        object.__setattr__(self, "prescribed", prescribed)
        if self.times is not None:
            object.__setattr__(self, "times", _times(f"{where} times", self.times))

    @property
    def free(self) -> Booleans:
        """The degrees of freedom that are not held, shape (n, d)."""
        return ~self.supports


def _times(name: str, times: Floats) -> Floats:
    times = require_positive(name, require_shape(name, floats(name, times), ("t",)))
    if not len(times) or (np.diff(times) <= 0).any():
        raise UserError(f"{name} must be one or more, ascending, but are {times}.")
    return times


def _supports(name: str, supports: Booleans, shape: tuple[int, ...]) -> Booleans:
    held = booleans(name, supports)
    if held.ndim == 1:
        held = np.repeat(held[:, None], shape[1], axis=1)
    return require_shape(name, held, shape)


def _prescribe(name: str, supports: Booleans, prescribed: Floats) -> tuple[Booleans, Floats]:
    """Supports with the prescribed degrees of freedom among them, and the displacements, zero where nothing is held."""
    require_shape(name, prescribed, supports.shape)
    nothing = np.isnan(prescribed)
    displacements = require_finite(name, np.where(nothing, 0.0, prescribed))
    if nothing.any():
        return supports | ~nothing, displacements
    stray = np.argwhere((displacements != 0) & ~supports)
    if len(stray):
        node, axis = stray[0]
        raise UserError(
            f"{name}[{node}, {axis}] is {displacements[node, axis]:g}, but nothing holds it there; "
            "make it a support, or give nan where nothing is prescribed."
        )
    return supports, displacements
