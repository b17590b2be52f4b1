"""The effect contract: one physical contribution beside the springs.

An effect declares what it brings, and the forward solve takes only that: a constant force is added to the load cases
before anything is solved and costs nothing in the loop; a potential brings a compiled kernel, which the loop calls for
eight equilibria at once. An effect in a file of its own, found by whoever imports it; engines never ask which it is.

A kernel is compiled with `numba.cfunc(KERNEL_SIGNATURE)`, so that its address is all the forward solve needs to know:

    (d, n, nodes, parameters, block_of, first, start, displacements, forces, tangent, energy)

`nodes` (n d), `block_of` (n), `first`, `start` describe the lattice and the tangent's envelope (`forward.plan`); the
last four are lane blocks (`effects.lanes`): `displacements` (n d, 8) to read, `forces` (n d, 8) the internal forces,
`tangent` (rows, 8) and `energy` (1, 8) to add to. `tangent_block` finds the rows of the block of two nodes.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from llvmlite import ir
from numba import njit, types
from numpy.typing import NDArray

from springopt.effects.lanes import intrinsic
from springopt.lattice import SpringLattice

_INTEGERS, _FLOATS = types.CPointer(types.int64), types.CPointer(types.float64)
KERNEL_SIGNATURE = types.void(
    types.int64, types.int64, _FLOATS, _FLOATS, _INTEGERS, _INTEGERS, _INTEGERS, _FLOATS, _FLOATS, _FLOATS, _FLOATS
)


@dataclass(frozen=True)
class Effect:
    """Base of the effects; a subclass is a frozen dataclass of its options and overrides what it brings."""

    def constant_forces(self, lattice: SpringLattice) -> NDArray[np.float64] | None:
        """Nodal forces [force] that depend on nothing, shape (n, d), or None."""
        return None

    def kernel(self, dimension: int) -> Any:
        """The compiled kernel (a `numba.cfunc` of KERNEL_SIGNATURE) of a nonlinear potential, or None."""
        return None

    def couplings(self, lattice: SpringLattice) -> NDArray[np.int64]:
        """The pairs of different nodes whose blocks the kernel adds to, shape (p, 2)."""
        return np.zeros((0, 2), dtype=np.int64)

    def parameters(self, lattice: SpringLattice) -> NDArray[np.float64]:
        """What the kernel finds in `parameters`."""
        return np.zeros(0)


@njit(error_model="numpy")
def tangent_block(block_of: Any, first: Any, start: Any, d: int, i: int, j: int) -> int:
    """The first of the d * d rows of the block that couples nodes i and j; -1 where the tangent has none.

    Row by row for the later of the two nodes in the elimination order (`block_of` ascending), column by column for the
    other.
    """
    row, column = max(block_of[i], block_of[j]), min(block_of[i], block_of[j])
    if column < 0:
        return -1
    return (start[row] + column - first[row]) * d * d


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
