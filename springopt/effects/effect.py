"""The effect contract: one physical contribution beside the springs.

An effect declares what it brings, and the forward solve takes only that. A constant force is added to the load cases
before anything is solved, and rest lengths are data: both cost nothing in the loop. A potential brings a compiled
kernel, which the loop calls for eight equilibria at once; so does a dissipation, in motion only. Masses make motion
possible. An effect lives in a file of its own, found by whoever imports it; engines never ask which it is.

A kernel is compiled by `compile.kernel`, so that its address is all the forward solve needs to know:

    (d, n, nodes, integers, numbers, stiffness, values, places,
     displacements, velocities, forces, tangent, energy)

`nodes` (n d), and `integers` and `numbers`, which the effect packed, are the same for all. The others are lane blocks
(`effects.lanes`): `stiffness` (s, 8) of the springs, `values` (k, 8) of the effect's own parameters, `displacements`
and `velocities` (n d, 8) to read; `forces` (n d, 8), `tangent` (rows, 8) and `energy` (1, 8) to add to. A potential
adds its energy, internal forces dE/du and their derivatives by u, and finds no velocities; a dissipation adds the power
that it takes, its forces against the motion and their derivatives by the velocity. `places` (q) says where in the
tangent the block of each pair of nodes goes that the effect declared: `blocks.add_to_block` reads it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import numpy as np
from llvmlite import ir
from numba import types

from springopt.checks import Floats, Integers
from springopt.effects.lanes import intrinsic
from springopt.errors import UserError
from springopt.lattice import SpringLattice

_INTEGERS, _FLOATS = types.CPointer(types.int64), types.CPointer(types.float64)
KERNEL_SIGNATURE = types.void(
    types.int64,
    types.int64,
    _FLOATS,
    _INTEGERS,
    _FLOATS,
    _FLOATS,
    _FLOATS,
    _INTEGERS,
    _FLOATS,
    _FLOATS,
    _FLOATS,
    _FLOATS,
    _FLOATS,
)
#: What an effect is told of the parameters that candidates differ in: none.
NOT_FITTED: frozenset[str] = frozenset()


@dataclass(frozen=True, eq=False)
class Kernel:
    """A compiled kernel, and what it reads that is the same for all equilibria."""

    function: Any  #: has an `address`: that of a function of KERNEL_SIGNATURE; one in Python may have a `failure`
    pairs: Integers  #: the nodes (i, j) whose blocks dF_i / du_j it adds to, in the order of its places, shape (q, 2)
    integers: Integers = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    numbers: Floats = field(default_factory=lambda: np.zeros(0))
    is_compiled: bool = True  #: False where Python is called back, which is slow
    #: Of a potential: the discrete gradient on the way from one state, in place of the velocities, to another, the
    #: displacements, as a function of its own: forces whose work is the energy's change, to rounding, and their
    #: derivatives by the displacements. Without one, motion takes the mean of the kernel at two points of the way.
    between: Any = None

    def on_the_way(self) -> "Kernel":
        """The kernel of the discrete gradient."""
        return replace(self, function=self.between, between=None)

    def raise_failure(self) -> None:
        """Raise, once, the first error inside a kernel that is Python: its compiled callers can't let it through."""
        failure = None if self.is_compiled else getattr(self.function, "failure", None)
        if failure is not None:
            self.function.failure = None
            raise failure


@dataclass(frozen=True)
class Effect:
    """Base of the effects; a subclass is a frozen dataclass of its options and overrides what it brings.

    `fitted` names those of its parameters in which candidates differ. What it brings may depend on them: a constant
    force whose factor is fitted is a potential.
    """

    name: ClassVar[str] = ""  #: what a scene calls it
    #: Whether it acts from outside, as weights and contact do, and not by the springs: then a reference obeys it too.
    acts_from_outside: ClassVar[bool] = False
    #: Whether small displacements may take its expansion at rest; where that would be another physics it is refused.
    has_expansion_at_rest: ClassVar[bool] = True
    #: Whether its potential is a law of the springs, in proportion to the stiffness of each.
    scales_with_stiffness: ClassVar[bool] = False
    #: Whether its forces are linear in its parameters, but for a constant; else it overrides `force_derivatives`.
    is_affine: ClassVar[bool] = True
    #: Whether moving the whole body costs nothing: net force zero, and nothing dissipated by a common velocity.
    is_translation_invariant: ClassVar[bool] = True
    #: Whether turning it costs nothing, likewise; about the origin, where it is not translation invariant.
    is_rotation_invariant: ClassVar[bool] = True

    def parameters(self, lattice: SpringLattice) -> dict[str, Floats]:
        """What may be fitted, with its value here, shape (k,) each; kernels find all of it in `values`, in this order.

        Raises UserError for options that do not fit the lattice.
        """
        return {}

    def constant_forces(self, lattice: SpringLattice, fitted: frozenset[str] = NOT_FITTED) -> Floats | None:
        """Nodal forces [force] that depend on nothing, shape (n, d), or None."""
        return None

    def rest_lengths(self, lattice: SpringLattice, fitted: frozenset[str] = NOT_FITTED) -> Floats | None:
        """Rest lengths [length] in place of the lattice's, shape (s,), or None."""
        return None

    def potential(self, lattice: SpringLattice, fitted: frozenset[str] = NOT_FITTED) -> Kernel | None:
        """The kernel of a potential, or None."""
        return None

    def force_derivatives(
        self, lattice: SpringLattice, displacements: Floats, *, stiffness: Floats, values: Floats, is_linear: bool
    ) -> Floats:
        """The derivatives of the potential's internal forces by its parameters (k,), shape (k, n d).

        At displacements (n d,); for small ones, `is_linear`, those of the forces' expansion at rest. Asked only where
        `is_affine` is False; else calls of the kernel tell them.
        """
        raise AttributeError(f"{type(self).__name__} is not affine in its parameters, but gives no derivatives by them")

    def dissipation(self, lattice: SpringLattice) -> Kernel | None:
        """The kernel of a dissipation, or None."""
        return None

    def masses(self, lattice: SpringLattice, values: Mapping[str, Floats]) -> Floats | None:
        """Mass of each node, shape (..., n), for parameters of shape (..., k) each, linear in them; or None."""
        return None


def checked_effects(effects: Sequence[Effect] | Effect | None) -> tuple[Effect, ...]:
    """The effects of a list, or the one that was given in place of it; refuses what is none."""
    several = (effects,) if isinstance(effects, Effect) else tuple(effects or ())
    for effect in several:
        if not isinstance(effect, Effect):
            raise UserError(f"effects must be a list of Effect, not {type(effect).__name__}; try Gravity((0, -9.81)).")
    return several


@intrinsic
def call_kernel(typing: Any, address: Any, d: Any, n: Any, arrays: Any) -> Any:
    """Call the kernel at this address with the tuple of arrays of KERNEL_SIGNATURE.

    By address and not as a first-class function, so that the compiled loop does not depend on which effects there are.
    """

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        pointers = [
            context.make_array(kind)(context, builder, builder.extract_value(arguments[3], k)).data
            for k, kind in enumerate(signature.args[3])
        ]
        integer = ir.IntType(64)
        kind = ir.FunctionType(ir.VoidType(), [integer, integer, *(pointer.type for pointer in pointers)])
        function = builder.inttoptr(arguments[0], kind.as_pointer())
        builder.call(function, [arguments[1], arguments[2], *pointers])
        return context.get_dummy_value()

    return types.void(types.int64, types.int64, types.int64, arrays), generate
