"""The finite element reference: small-displacement linear elasticity, assembled by scikit-fem."""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import SuperLU, splu
from skfem import (
    Basis,
    ElementHex1,
    ElementQuad1,
    ElementTetP1,
    ElementTriP1,
    ElementVector,
    MeshHex1,
    MeshQuad1,
    MeshTet1,
    MeshTri1,
)
from skfem.models.elasticity import linear_elasticity

from springopt.cells import check_cells, require_regular_cells
from springopt.checks import Floats, Integers, floats, require_finite, require_positive, require_shape
from springopt.errors import UserError
from springopt.lattice import SpringLattice
from springopt.load_case import LoadCase
from springopt.mesh import read_mesh
from springopt.reference.rigid_modes import RigidModes


class _Discretization(NamedTuple):
    """How scikit-fem treats a cell type: its mesh, its element, its numbering of our corners, its quadrature."""

    mesh: Any
    element: Any
    corners: list[int]
    #: Integration order: two Gauss points a direction on quadrilaterals and hexahedra, the constant of a simplex.
    order: int


_DISCRETIZATIONS = {
    "triangle": _Discretization(MeshTri1, ElementTriP1, [0, 1, 2], 1),
    "quad": _Discretization(MeshQuad1, ElementQuad1, [0, 1, 2, 3], 3),
    "tetra": _Discretization(MeshTet1, ElementTetP1, [0, 1, 2, 3], 1),
    "hexahedron": _Discretization(MeshHex1, ElementHex1, [6, 2, 5, 7, 1, 3, 4, 0], 3),
}


@dataclass(frozen=True, eq=False)
class FemReference:
    """A linear elastic body on first-order finite elements.

    The body is homogeneous and isotropic; displacements are taken as small, so that they grow in proportion to the
    load. Quadrilaterals and hexahedra are fully integrated, with two Gauss points in each direction.
    """

    #: A lattice with cells, a meshio mesh, a mesh file, or (nodes (n, d), cells (c, v), cell type); kept as the last.
    mesh: Any
    young: float = field(kw_only=True)  #: Young's modulus [force / area]
    poisson: float = field(kw_only=True)  #: Poisson's ratio
    plane: str = field(default="stress", kw_only=True)  #: "stress" or "strain"; without meaning in 3D
    thickness: float = field(default=1.0, kw_only=True)  #: [length], without meaning in 3D
    #: One factor for each set of supports, kept because load cases share them.
    _factors: dict[bytes, SuperLU] = field(default_factory=dict, init=False, repr=False)

    def __post_init__(self) -> None:
        nodes, cells, cell_type = _mesh_parts(self.mesh)
        require_regular_cells(nodes, cells, cell_type)
        for name in ("young", "thickness"):
            require_positive(name, require_shape(name, floats(name, getattr(self, name)), ()))
        if self.plane not in ("stress", "strain"):
            raise UserError(f"plane must be 'stress' or 'strain', not {self.plane!r}.")
        _check_poisson(self.poisson, is_plane_stress=self._is_plane_stress(nodes))
        object.__setattr__(self, "mesh", (nodes, cells, cell_type))

    def deform(self, case: LoadCase) -> Floats:
        """Positions under the load case [length], shape (n, d); refuses supports that leave the body free to move."""
        nodes = self.mesh[0]
        require_shape(f"load case {case.name!r}: forces", case.forces, nodes.shape)
        free = case.free.ravel()
        displacements = case.prescribed.ravel().copy()
        if free.any():
            loads = case.forces.ravel() - self.stiffness_matrix @ displacements
            displacements[free] = self._factor(case).solve(loads[free])
        return nodes + displacements.reshape(nodes.shape)

    @cached_property
    def stiffness_matrix(self) -> csc_matrix:
        """Stiffness of the unsupported body [force / length], shape (n d, n d), the axes of a node side by side."""
        nodes, cells, cell_type = self.mesh
        kind = _DISCRETIZATIONS[cell_type]
        mesh = kind.mesh(np.ascontiguousarray(nodes.T), np.ascontiguousarray(cells[:, kind.corners].T))
        basis = Basis(mesh, ElementVector(kind.element()), intorder=kind.order)
        numbers = basis.nodal_dofs.T.ravel()
        matrix = csc_matrix(linear_elasticity(*self._lame_parameters()).assemble(basis))[numbers][:, numbers]
        return matrix if nodes.shape[1] == 3 else self.thickness * matrix

    @cached_property
    def _rigid_modes(self) -> RigidModes:
        return RigidModes(*self.mesh)

    def _factor(self, case: LoadCase) -> SuperLU:
        key = case.supports.tobytes()
        if key not in self._factors:
            mode_count = self._rigid_modes.count_free(case.supports)
            if mode_count:
                raise UserError(
                    f"Load case {case.name!r} leaves the body free to move in {mode_count} rigid "
                    f"mode{'s' if mode_count > 1 else ''}; hold more nodes."
                )
            free = np.flatnonzero(case.free)
            self._factors[key] = splu(
                self.stiffness_matrix[free][:, free],
                permc_spec="MMD_AT_PLUS_A",
                diag_pivot_thresh=0.0,
                options={"SymmetricMode": True},
            )
        return self._factors[key]

    def _lame_parameters(self) -> tuple[float, float]:
        """Lame's parameters; in plane stress the first is the one that makes the stress across the plane vanish."""
        young, poisson = self.young, self.poisson
        shear = young / (2 * (1 + poisson))
        if self._is_plane_stress(self.mesh[0]):
            return young * poisson / (1 - poisson**2), shear
        return young * poisson / ((1 + poisson) * (1 - 2 * poisson)), shear

    def _is_plane_stress(self, nodes: Floats) -> bool:
        return nodes.shape[1] == 2 and self.plane == "stress"


def _mesh_parts(mesh: Any) -> tuple[Floats, Integers, str]:
    """Nodes, cells and cell type of whatever was given, every node in some cell."""
    if isinstance(mesh, SpringLattice):
        if mesh.cells is None or mesh.cell_type is None:
            raise UserError("A finite element reference needs a lattice with cells; give it cells and cell_type.")
        nodes, cells, cell_type = mesh.nodes, mesh.cells, mesh.cell_type
    elif isinstance(mesh, tuple):
        if len(mesh) != 3:
            raise UserError(f"A mesh given as a tuple must be (nodes, cells, cell type), not {len(mesh)} things.")
        nodes = require_finite("nodes", require_shape("nodes", floats("nodes", mesh[0]), ("n", "d")))
        cells, cell_type = check_cells(mesh[1], mesh[2], nodes), mesh[2]
    else:
        nodes, cells, cell_type = read_mesh(mesh)
    stray = np.setdiff1d(np.arange(len(nodes)), cells)
    if len(stray):
        raise UserError(f"Node {stray[0]} belongs to no cell; a finite element reference can't tell where it goes.")
    return nodes, cells, cell_type


def _check_poisson(poisson: float, *, is_plane_stress: bool) -> None:
    """Plane stress bears the incompressible 0.5; where the volume can't escape across the plane it divides by zero."""
    ratio = float(require_shape("poisson", floats("poisson", poisson), ()))
    if not (-1 < ratio < 0.5 or (is_plane_stress and ratio == 0.5)):
        limit = "at most 0.5 in plane stress" if is_plane_stress else "below 0.5 in plane strain and in 3D"
        raise UserError(f"Poisson's ratio must be above -1 and {limit}, not {ratio:g}.")
