"""The finite element reference: an elastic body at small or large strain, in equilibrium or in motion."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from scipy.sparse import csc_matrix, diags_array, eye_array, kron

from springopt.checks import Floats, Integers, floats, require_nonnegative, require_positive, require_shape
from springopt.effects.effect import Effect, checked_effects
from springopt.errors import UserError, did_you_mean
from springopt.lattice import SpringLattice
from springopt.load_case import LoadCase
from springopt.nodal_volumes import nodal_volumes
from springopt.reference.body_among_effects import BodyAmongEffects, LinearBody, Potential
from springopt.reference.body_forces import body_forces
from springopt.reference.discretization import ORDERS, discretize, mass_matrix
from springopt.reference.elastic_body import ElasticBody
from springopt.reference.elements import StandardElements
from springopt.reference.factor import Factor
from springopt.reference.fem_mesh import bare_lattice, fem_mesh
from springopt.reference.finite_strain import FiniteStrain
from springopt.reference.material import Material
from springopt.reference.mean_dilatation import MeanDilatationElements
from springopt.reference.refinement import Refinement
from springopt.reference.rigid_modes import RigidModes
from springopt.reference.spread_contact import spread_potentials
from springopt.reference.vibration import Vibration

FORMULATIONS = ("standard", "b-bar")


@dataclass(frozen=True, eq=False)
class FemReference:
    """An elastic body on finite elements, homogeneous and isotropic.

    With the law "linear" displacements are taken as small, so that they grow in proportion to the load, and a load
    case may have times. "saint-venant-kirchhoff" and "neo-hookean" are at large strain, in equilibrium only; a load
    without a stable equilibrium is refused. Elements are fully integrated: quadrilaterals and hexahedra of first order
    with two Gauss points in each direction, of second order with three.

    In plane strain and in 3D standard elements lock above a Poisson's ratio of about 0.49: they are too stiff, at
    0.4999 many times. "b-bar" does not: its volume strain is the mean over the cell, which quadrilaterals and
    hexahedra bear.

    Elements of second order, and cells that are divided, tell better what the same body does at the same nodes. What
    is done to the nodes is then done to what lies between them, see `Refinement`: supports hold the facets that they
    fill, nodal forces are the tractions that they stand for, and contact is spread over the boundary.
    """

    #: A lattice with cells, a meshio mesh, a mesh file, or (nodes (n, d), cells (c, v), cell type); kept as the last.
    mesh: Any
    young: float = field(kw_only=True)  #: Young's modulus [force / area]
    poisson: float = field(kw_only=True)  #: Poisson's ratio
    plane: str = field(default="stress", kw_only=True)  #: "stress" or "strain"; without meaning in 3D
    thickness: float = field(default=1.0, kw_only=True)  #: at rest [length], without meaning in 3D
    law: str = field(default="linear", kw_only=True)  #: "linear", "saint-venant-kirchhoff" or "neo-hookean"
    formulation: str = field(default="standard", kw_only=True)  #: "standard" or "b-bar"
    order: int = field(default=1, kw_only=True)  #: 1 or 2, of the elements
    refinements: int = field(default=0, kw_only=True)  #: how often the cells are divided, every edge in two
    #: What acts from outside, as weights and contact; what an effect does to springs is not the body's.
    effects: Sequence[Effect] = field(default=(), kw_only=True)
    density: float | None = field(default=None, kw_only=True)  #: [mass / length^3], which motion needs
    mass_damping: float = field(default=0.0, kw_only=True)  #: times the mass matrix [1 / time]
    stiffness_damping: float = field(default=0.0, kw_only=True)  #: times the stiffness matrix [time]
    lumped: bool = field(default=False, kw_only=True)  #: whether the mass is in the nodes alone
    _lattice: SpringLattice = field(init=False, repr=False)
    _effect_forces: Floats = field(init=False, repr=False)  #: the effects' nodal forces [force], shape (n, d)
    _refinement: Refinement | None = field(init=False, repr=False)  #: None of first-order elements on the mesh itself
    #: One factor for each set of supports, kept because load cases share them.
    _factors: dict[bytes, Factor] = field(default_factory=dict, init=False, repr=False)
    _mode_counts: dict[bytes, int] = field(default_factory=dict, init=False, repr=False)

    def __post_init__(self) -> None:
        nodes, cells, cell_type = fem_mesh(self.mesh)
        lattice = self.mesh if isinstance(self.mesh, SpringLattice) else bare_lattice(nodes, cells, cell_type)
        object.__setattr__(self, "mesh", (nodes, cells, cell_type))
        self._check_options()
        object.__setattr__(self, "effects", checked_effects(self.effects))
        object.__setattr__(self, "_lattice", lattice)
        object.__setattr__(self, "_effect_forces", body_forces(lattice, self.effects, float(self.thickness)))
        is_finer = self.order > 1 or self.refinements > 0
        object.__setattr__(
            self, "_refinement", Refinement(self.mesh, self.refinements, self.order) if is_finer else None
        )
        if is_finer:
            _ = self._spread_potentials  # what can't be spread is refused at once

    def deform(self, case: LoadCase) -> Floats:
        """Positions under the load case [length], shape (n, d), or (t, n, d) where it has times.

        At rest, supports must not leave the body free to move. In motion it starts at rest, undeformed, and whatever
        is held is from the first moment where it is prescribed to be.
        """
        nodes = self.mesh[0]
        require_shape(f"load case {case.name!r}: forces", case.forces, nodes.shape)
        if case.times is None:
            self._require_supports(case)
        return nodes + self._displacements(case)[..., : len(nodes), :]

    def _displacements(self, case: LoadCase) -> Floats:
        """Of all nodes of the elements [length], shape (k, d), or (t, k, d) where the load case has times."""
        rigid_count = self._rigid_mode_count(case)
        case, loads = self._acting(case)
        if case.times is not None:
            return self._motion(case, loads, rigid_count)
        if self.law == "linear" and not self._surroundings.potentials:
            return self._small_displacements(case, loads)
        return self._large_displacements(case, loads)

    def _acting(self, case: LoadCase) -> tuple[LoadCase, Floats]:
        """The load case on all nodes of the elements, and its forces with those of the effects [force], (k, d)."""
        if self._refinement is None:
            return case, case.forces + self._effect_forces
        case = self._refinement.load_case(case)
        return case, case.forces + self._spread_effect_forces

    @cached_property
    def _spread_effect_forces(self) -> Floats:
        """The effects' nodal forces on all nodes of the elements [force], shape (k, d)."""
        assert self._refinement is not None  # else they are what they are
        return self._refinement.body_loads(self._effect_forces)

    @cached_property
    def body(self) -> ElasticBody:
        """Energy, internal forces and tangent at large strain; of the law "linear" the stiffness at rest is meant."""
        elements = MeanDilatationElements if self.formulation == "b-bar" else StandardElements
        discretization = discretize(*self._element_mesh, self.order)
        count = int(discretization.cells.max()) + 1
        return ElasticBody(elements(discretization, self._material.law(self.law)), count, self._thickness)

    @property
    def _element_mesh(self) -> tuple[Floats, Integers, str]:
        """The cells that bear the elements."""
        return self.mesh if self._refinement is None else self._refinement.mesh

    @cached_property
    def _surroundings(self) -> BodyAmongEffects:
        """The body, and what touches it."""
        body = LinearBody(self.stiffness_matrix) if self.law == "linear" else self.body
        if self._refinement is None:
            return BodyAmongEffects.of(body, self._lattice, self.effects)
        return BodyAmongEffects(body, *self._spread_potentials)

    @cached_property
    def _spread_potentials(self) -> tuple[SpringLattice, list[Potential]]:
        """All nodes of the elements, and what touches them."""
        assert self._refinement is not None  # else they are the lattice's
        return spread_potentials(self._refinement, self._lattice, self.effects)

    @cached_property
    def stiffness_matrix(self) -> csc_matrix:
        """Stiffness of the unsupported body [force / length], shape (k d, k d), the axes of a node side by side.

        The k nodes of the elements are those of the mesh, followed by those that order and refinements add.
        """
        return self.body.stiffness_matrix

    @cached_property
    def _material(self) -> Material:
        return Material(self.young, self.poisson, self._is_plane_stress)

    @property
    def _is_plane_stress(self) -> bool:
        return self.mesh[0].shape[1] == 2 and self.plane == "stress"

    @property
    def _thickness(self) -> float:
        return self.thickness if self.mesh[0].shape[1] == 2 else 1.0

    @cached_property
    def _rigid_modes(self) -> RigidModes:
        return RigidModes(*self.mesh)

    def _small_displacements(self, case: LoadCase, loads: Floats) -> Floats:
        """Shape (k, d)."""
        displacements = case.prescribed.copy()
        if case.free.any():
            left = loads - (self.stiffness_matrix @ displacements.ravel()).reshape(loads.shape)
            displacements[case.free] = self._factor(case).solve(left[case.free])
        return displacements

    def _large_displacements(self, case: LoadCase, loads: Floats) -> Floats:
        """Shape (k, d)."""
        acting = np.where(case.free, loads, 0.0)  # a force on a support must not loosen the tolerance
        size = float(np.ptp(self.mesh[0], axis=0).max())
        return FiniteStrain(self._surroundings, case, acting, self.stiffness_matrix, size).displacements()

    def _factor(self, case: LoadCase) -> Factor:
        key = case.supports.tobytes()
        if key not in self._factors:
            free = np.flatnonzero(case.free)
            self._factors[key] = Factor.of(self.stiffness_matrix[free][:, free])
        return self._factors[key]

    def _require_supports(self, case: LoadCase) -> None:
        mode_count = self._rigid_mode_count(case)
        if mode_count:
            raise UserError(
                f"Load case {case.name!r} leaves the body free to move in {mode_count} rigid "
                f"mode{'s' if mode_count > 1 else ''}; hold more nodes."
            )

    def _rigid_mode_count(self, case: LoadCase) -> int:
        key = case.supports.tobytes()
        if key not in self._mode_counts:
            self._mode_counts[key] = self._rigid_modes.count_free(case.supports)
        return self._mode_counts[key]

    def _motion(self, case: LoadCase, loads: Floats, rigid_count: int) -> Floats:
        """Displacements [length], shape (t, k, d)."""
        if self.law != "linear":
            raise UserError(
                f"Load case {case.name!r} has times, but the law {self.law!r} knows equilibria only; take the law "
                "'linear', or leave the times out."
            )
        if self._surroundings.potentials:
            raise UserError(
                f"Load case {case.name!r} has times, and the finite element reference knows contact in equilibrium "
                "only; leave one of the two out."
            )
        return self._vibration.displacements(case, loads, rigid_count)

    @cached_property
    def _vibration(self) -> Vibration:
        if self.density is None:
            raise UserError(
                "A load case with times needs a body with mass; give the finite element reference a density."
            )
        mesh = self._element_mesh
        volumes = diags_array(nodal_volumes(*mesh)) if self.lumped else mass_matrix(*mesh, self.order)
        return Vibration(
            stiffness=self.stiffness_matrix,
            mass=csc_matrix(kron(self.density * self._thickness * volumes, eye_array(self.mesh[0].shape[1]))),
            mass_damping=self.mass_damping,
            stiffness_damping=self.stiffness_damping,
        )

    def _check_options(self) -> None:
        require_positive("thickness", require_shape("thickness", floats("thickness", self.thickness), ()))
        if self.plane not in ("stress", "strain"):
            raise UserError(f"plane must be 'stress' or 'strain', not {self.plane!r}.")
        self._check_formulation()
        self._check_elements()
        _ = self._material.law(self.law)
        if self.density is not None:
            require_positive("density", require_shape("density", floats("density", self.density), ()))
        for name in ("mass_damping", "stiffness_damping"):
            require_nonnegative(name, require_shape(name, floats(name, getattr(self, name)), ()))

    def _check_elements(self) -> None:
        if isinstance(self.order, bool) or self.order not in ORDERS:
            raise UserError(f"order must be 1 or 2, of the elements, not {self.order!r}.")
        if isinstance(self.refinements, bool) or not isinstance(self.refinements, int) or self.refinements < 0:
            raise UserError(f"refinements must be a whole number, 0 or more, not {self.refinements!r}.")
        if self.order == 2 and self.formulation == "b-bar":
            raise UserError(
                "The formulation 'b-bar' is for first-order elements; take 'standard', since those of second order "
                "hardly lock, or the order 1."
            )
        if self.order == 2 and self.lumped:
            raise UserError(
                "A lumped mass is for first-order elements, whose nodes all have a volume; leave it out, or take the "
                "order 1."
            )

    def _check_formulation(self) -> None:
        if self.formulation not in FORMULATIONS:
            hint = did_you_mean(str(self.formulation), FORMULATIONS)
            raise UserError(f"formulation must be 'standard' or 'b-bar', not {self.formulation!r}.{hint}")
        cell_type = self.mesh[2]
        if self.formulation == "b-bar" and cell_type in ("triangle", "tetra"):
            other = "quad" if cell_type == "triangle" else "hexahedron"
            raise UserError(
                f"The formulation 'b-bar' does not help {cell_type} cells, whose volume strain is constant already; "
                f"use {other} cells."
            )
        if self.formulation == "b-bar" and self._is_plane_stress:
            raise UserError(
                "The formulation 'b-bar' is for plane strain and 3D; plane stress does not lock, so leave it out."
            )
