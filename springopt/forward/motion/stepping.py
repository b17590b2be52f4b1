"""How motion goes on in time: the integrator, its steps, and how exact they are."""

from dataclasses import dataclass

from springopt.checks import floats, require_positive, require_shape
from springopt.errors import UserError, did_you_mean

INTEGRATORS = ENERGY_MOMENTUM, L_STABLE = ("energy-momentum", "l-stable")


@dataclass(frozen=True)
class Stepping:
    """Implicit steps of second order.

    "energy-momentum": forces are a discrete gradient of the energy (Gonzalez 1996), so that without damping energy and
    momentum stay what they are, over any number of steps. "l-stable": two stages of the singly diagonal Runge-Kutta
    method with gamma = 1 - sqrt(1/2) (Alexander 1977), which damps what a step can't resolve, as in stiff contact, and
    takes nodes without mass. A step that would gain energy, as one across an impact may, is one of the implicit Euler
    method in its place.
    """

    step: float  #: [time], the longest; steps between two times are equal
    integrator: str = ENERGY_MOMENTUM  #: "energy-momentum" or "l-stable"
    #: What a step may be off by, as a share of a typical spring's length: steps become as short as that takes. None
    #: keeps them all at `step`.
    step_error: float | None = None

    def __post_init__(self) -> None:
        require_positive("step", require_shape("step", floats("step", self.step), ()))
        if self.integrator not in INTEGRATORS:
            hint = did_you_mean(str(self.integrator), INTEGRATORS)
            raise UserError(f"integrator must be one of {', '.join(INTEGRATORS)}, not {self.integrator!r}.{hint}")
        if self.step_error is not None:
            require_positive("step_error", require_shape("step_error", floats("step_error", self.step_error), ()))
