"""Elements of mean dilatation, which do not lock where the material is nearly incompressible."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from springopt.checks import Floats
from springopt.reference.discretization import Discretization
from springopt.reference.elements import as_matrices, displacement_gradients, strain_rows
from springopt.reference.law import Law, volume_strain


class _Dilatation(NamedTuple):
    """Volumes at the Gauss points, and how the logarithms of them move with the displacements of a cell."""

    scales: Floats  #: (mean of J over the cell / J)^(1/3), shape (c, q)
    shares: Floats  #: of each Gauss point in the volume of its deformed cell, shape (c, q)
    slopes: Floats  #: of ln J at each Gauss point [1 / length], shape (c, q, v, d)
    mean_slopes: Floats  #: of the logarithm of the mean, shape (c, v, d)


@dataclass(frozen=True, eq=False)
class MeanDilatationElements:
    """Quadrilaterals in plane strain and hexahedra whose volume strain is the mean over the cell.

    The energy is W((mean J / J)^(1/3) F): with the volumetric part of W apart it is the three-field element of Simo,
    Taylor and Pister (1985), its pressure and dilatation constant in the cell and eliminated. Its tangent is
    symmetric, and at rest that of Hughes's B-bar (1980). The law is the one in space, also in plane strain.
    """

    discretization: Discretization
    law: Law

    def is_admissible(self, displacements: Floats) -> bool:
        return bool((volume_strain(displacement_gradients(self.discretization, displacements)) > -1.0).all())

    def energies(self, displacements: Floats) -> Floats:
        strains = self._strains(displacements, self._dilatation(displacements))
        return np.sum(self.discretization.weights * self.law.energy(strains), axis=1)

    def forces(self, displacements: Floats) -> Floats:
        dilatation = self._dilatation(displacements)
        strains = self._strains(displacements, dilatation)
        stresses = self.law.stress(strains) * self.discretization.weights[..., None, None]
        total = np.zeros((len(displacements), displacements[0].size))
        for point in range(strains.shape[1]):
            rows = self._rows(strains, dilatation, point)
            total += np.einsum("csx,cs->cx", rows, _flat(stresses[:, point]))
        return total

    def tangents(self, displacements: Floats) -> Floats:
        dilatation = self._dilatation(displacements)
        strains = self._strains(displacements, dilatation)
        total = np.zeros((len(displacements), displacements[0].size, displacements[0].size))
        mean_curvature = _mean_curvature(dilatation)
        for point in range(strains.shape[1]):
            weights = self.discretization.weights[:, point]
            stress = self.law.stress(strains[:, point]) * weights[:, None, None]
            moduli = self.law.moduli(strains[:, point]) * weights[:, None, None, None, None]
            rows = self._rows(strains, dilatation, point)
            total += rows.swapaxes(1, 2) @ as_matrices(moduli) @ rows
            curvature = (mean_curvature - _curvature(dilatation.slopes[:, point])) / 3
            total += self._geometric(strains, dilatation, stress, curvature, point)
        return total

    def _geometric(
        self, strains: Floats, dilatation: _Dilatation, stress: Floats, curvature: Floats, point: int
    ) -> Floats:
        """What the stress (c, 3, 3) adds to the tangents: the second derivatives of the scaled gradient s F.

        Those are s F (r r + dr) + r x (s dF) + (s dF) x r, with r the slopes of ln s.
        """
        plain = strain_rows(self.discretization.gradients[:, point], 3) * dilatation.scales[:, point, None, None]
        gradient = strains[:, point] + np.eye(3)
        slopes = _log_scale_slopes(dilatation, point)
        pulled = np.einsum("csx,cs->cx", plain, _flat(stress))
        work = np.einsum("cij,cij->c", stress, gradient)
        mixed = _outer(slopes, pulled)
        return work[:, None, None] * (_outer(slopes, slopes) + curvature) + mixed + mixed.swapaxes(1, 2)

    def _rows(self, strains: Floats, dilatation: _Dilatation, point: int) -> Floats:
        """What displacements make of the scaled gradient at a Gauss point, shape (c, 9, v d)."""
        plain = strain_rows(self.discretization.gradients[:, point], 3) * dilatation.scales[:, point, None, None]
        return plain + _outer(_flat(strains[:, point] + np.eye(3)), _log_scale_slopes(dilatation, point))

    def _strains(self, displacements: Floats, dilatation: _Dilatation) -> Floats:
        """The scaled deformation gradient in space, less I, shape (c, q, 3, 3)."""
        plain = displacement_gradients(self.discretization, displacements)
        d = plain.shape[-1]
        scales = dilatation.scales[..., None, None]
        strains = (scales - 1.0) * np.eye(3)
        strains[..., :d, :d] += scales * plain
        return strains

    def _dilatation(self, displacements: Floats) -> _Dilatation:
        weights, gradients = self.discretization.weights, self.discretization.gradients
        strains = displacement_gradients(self.discretization, displacements)
        ratios = 1.0 + volume_strain(strains)
        volumes = weights * ratios
        means = volumes.sum(axis=1) / weights.sum(axis=1)
        slopes = gradients @ np.linalg.inv(strains + np.eye(strains.shape[-1]))
        shares = volumes / volumes.sum(axis=1)[:, None]
        return _Dilatation(
            scales=np.cbrt(means[:, None] / ratios),
            shares=shares,
            slopes=slopes,
            mean_slopes=np.einsum("cq,cqvi->cvi", shares, slopes),
        )


def _log_scale_slopes(dilatation: _Dilatation, point: int) -> Floats:
    return _flat(dilatation.mean_slopes - dilatation.slopes[:, point]) / 3


def _curvature(slopes: Floats) -> Floats:
    """The second derivatives of ln J from its first (c, v, d), shape (c, v d, v d)."""
    count, v, d = slopes.shape
    return -np.einsum("cvj,cwi->cviwj", slopes, slopes).reshape(count, v * d, v * d)


def _mean_curvature(dilatation: _Dilatation) -> Floats:
    """The second derivatives of the logarithm of the mean of J, shape (c, v d, v d)."""
    mean = _flat(dilatation.mean_slopes)
    total = -_outer(mean, mean)
    for point in range(dilatation.shares.shape[1]):
        slopes = dilatation.slopes[:, point]
        share = dilatation.shares[:, point, None, None]
        total += share * (_outer(_flat(slopes), _flat(slopes)) + _curvature(slopes))
    return total


def _outer(left: Floats, right: Floats) -> Floats:
    return left[:, :, None] * right[:, None, :]


def _flat(values: Floats) -> Floats:
    return values.reshape(len(values), -1)
