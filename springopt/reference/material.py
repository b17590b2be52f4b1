"""The isotropic material of a finite element reference, and the law that its name stands for."""

from dataclasses import dataclass

import numpy as np

from springopt.checks import floats, require_positive, require_shape
from springopt.errors import UserError, did_you_mean
from springopt.reference.law import Law
from springopt.reference.neo_hookean import NeoHookean, NeoHookeanPlaneStress
from springopt.reference.saint_venant_kirchhoff import SaintVenantKirchhoff

LAWS = ("linear", "saint-venant-kirchhoff", "neo-hookean")


@dataclass(frozen=True)
class Material:
    """An isotropic elastic material, and whether it is a thin sheet without stress across its plane."""

    young: float  #: Young's modulus [force / area]
    poisson: float  #: Poisson's ratio; plane stress bears the incompressible 0.5
    is_plane_stress: bool = False

    def __post_init__(self) -> None:
        require_positive("young", require_shape("young", floats("young", self.young), ()))
        ratio = float(require_shape("poisson", floats("poisson", self.poisson), ()))
        if not (-1 < ratio < 0.5 or (self.is_plane_stress and ratio == 0.5)):
            limit = "at most 0.5 in plane stress" if self.is_plane_stress else "below 0.5 in plane strain and in 3D"
            raise UserError(f"Poisson's ratio must be above -1 and {limit}, not {ratio:g}.")

    @property
    def shear(self) -> float:
        """The shear modulus [force / area], Lame's second parameter."""
        return self.young / (2 * (1 + self.poisson))

    @property
    def lame(self) -> float:
        """Lame's first parameter [force / area]; in plane stress the one for strains in the plane alone."""
        if self.is_plane_stress:
            return self.young * self.poisson / (1 - self.poisson**2)
        return self.young * self.poisson / ((1 + self.poisson) * (1 - 2 * self.poisson))

    def law(self, name: str) -> Law:
        """The law by its name; the linear one is the others' tangent at rest, and given as Saint Venant's."""
        if name not in LAWS:
            raise UserError(f"law must be one of {', '.join(LAWS)}, not {name!r}.{did_you_mean(str(name), LAWS)}")
        if name != "neo-hookean":
            across = 2 * self.poisson / (1 - self.poisson) if self.is_plane_stress else -np.inf
            return SaintVenantKirchhoff(self.lame, self.shear, across)
        if self.is_plane_stress:
            return NeoHookeanPlaneStress(self.shear, self.poisson)
        return NeoHookean(self.shear, self.lame)
