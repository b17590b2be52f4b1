"""The motion of a linear body after a sudden load."""

from dataclasses import dataclass, field

import numpy as np
from scipy.sparse import csc_matrix

from springopt.checks import Floats, Integers
from springopt.errors import UserError
from springopt.load_case import LoadCase
from springopt.reference.modes import Modes

#: Degrees of freedom whose modes are found: with matrices of (f, f), in ten seconds.
MOST = 3_000


@dataclass(frozen=True, eq=False)
class Vibration:
    """A linear body with mass, its damping in proportion to mass and stiffness (Rayleigh)."""

    stiffness: csc_matrix  #: [force / length], shape (n d, n d)
    mass: csc_matrix  #: shape (n d, n d)
    mass_damping: float  #: [1 / time]
    stiffness_damping: float  #: [time]
    #: The modes of each set of supports, kept because load cases share them.
    _modes: dict[bytes, Modes] = field(default_factory=dict, init=False, repr=False)

    def displacements(self, case: LoadCase, loads: Floats, rigid_count: int) -> Floats:
        """At the times of the load case [length], shape (t, n, d), under nodal loads (n, d).

        `rigid_count` is the number of motions without strain that its supports leave free.
        """
        times = np.zeros(0) if case.times is None else case.times
        displacements = np.repeat(case.prescribed[None], len(times), axis=0)
        free = np.flatnonzero(case.free)
        if len(free):
            acting = (loads.ravel() - self.stiffness @ case.prescribed.ravel())[free]
            modes = self._modes_of(case, free, rigid_count)
            displacements[:, case.free] = modes.motion(
                acting, times, mass_damping=self.mass_damping, stiffness_damping=self.stiffness_damping
            )
        return displacements

    def _modes_of(self, case: LoadCase, free: Integers, rigid_count: int) -> Modes:
        key = case.supports.tobytes()
        if key not in self._modes:
            if len(free) > MOST:
                raise UserError(
                    f"The motion of load case {case.name!r} has {len(free):,} degrees of freedom, and at most {MOST:,} "
                    "can be solved for; take fewer nodes."
                )
            stiffness, mass = (matrix[free][:, free].toarray() for matrix in (self.stiffness, self.mass))
            self._modes[key] = Modes.of(stiffness, mass, rigid_count)
        return self._modes[key]
