"""A counter that several threads draw numbers from, each number once."""

from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numpy.typing import NDArray

from springopt.effects.compile import compiled
from springopt.effects.lanes import intrinsic


def make_counter() -> NDArray[np.int64]:
    """Starts at 0."""
    return np.zeros(1, dtype=np.int64)


@intrinsic
def _add_one(typing: Any, array: Any) -> Any:
    """What stood in the array's first place before 1 was added, in one indivisible step."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
        return builder.atomic_rmw("add", data, ir.Constant(ir.IntType(64), 1), "monotonic")

    return types.int64(array), generate


@compiled
def draw(counter: Any, end: int) -> int:
    """The next number of the counter below `end`, or -1 when there is none."""
    number = _add_one(counter) if counter[0] < end else end
    return number if number < end else -1
