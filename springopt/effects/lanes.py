"""A lane block: eight numbers that numba computes with as one, one lane for each equilibrium under way.

LLVM does not find this vectorization by itself (the lanes of one row share a pointer with those of the next), so
the type is spelled out: `Lanes` is LLVM's <8 x double>, with arithmetic, and arrays of shape (rows, 8) hold it row by
row. Every lane does the same operations in the same order whatever its neighbours hold, so that an answer never
depends on the company it was computed in. Built on numba's extension interface (`numba.extending`).
"""

import operator
from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic as _numba_intrinsic
from numba.extending import models, overload, register_model

LANE_COUNT = 8
# numba types an intrinsic as its generator, with one argument more than its callers pass.
intrinsic: Any = _numba_intrinsic
_VECTOR = ir.VectorType(ir.DoubleType(), LANE_COUNT)
_INDEX = ir.IntType(64)
# Rows start at any multiple of 8 bytes: NumPy aligns its arrays to 16 only.
_ALIGNMENT = 8


class LanesType(types.Type):
    """numba's name for one lane block."""

    def __init__(self) -> None:
        super().__init__(name=f"Lanes{LANE_COUNT}")


lanes = LanesType()


@register_model(LanesType)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, _VECTOR)


def _data(context: Any, builder: Any, array_type: Any, array: Any) -> Any:
    return context.make_array(array_type)(context, builder, array).data


def _pointer(builder: Any, data: Any, row: Any) -> Any:
    first = builder.mul(row, ir.Constant(_INDEX, LANE_COUNT))
    return builder.bitcast(builder.gep(data, [first]), _VECTOR.as_pointer())


def _load(builder: Any, data: Any, row: Any) -> Any:
    value = builder.load(_pointer(builder, data, row))
    value.align = _ALIGNMENT
    return value


def _store(builder: Any, data: Any, row: Any, value: Any) -> None:
    builder.store(value, _pointer(builder, data, row)).align = _ALIGNMENT


def _fused_multiply_add(builder: Any, a: Any, b: Any, c: Any) -> Any:
    # fmuladd: fused where the processor can, never a call into the C library.
    return _call(builder, "fmuladd", a, b, c)


def _call(builder: Any, name: str, *arguments: Any) -> Any:
    signature = ir.FunctionType(_VECTOR, [_VECTOR] * len(arguments))
    function = cgutils.get_or_insert_function(builder.module, signature, f"llvm.{name}.v{LANE_COUNT}f64")
    return builder.call(function, arguments)


@intrinsic
def load(typing: Any, array: Any, row: Any) -> Any:
    """One row of an array of shape (rows, 8)."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        index = context.cast(builder, arguments[1], signature.args[1], types.intp)
        return _load(builder, _data(context, builder, signature.args[0], arguments[0]), index)

    return lanes(array, row), generate


@intrinsic
def store(typing: Any, array: Any, row: Any, value: Any) -> Any:
    """Write one row of an array of shape (rows, 8)."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        index = context.cast(builder, arguments[1], signature.args[1], types.intp)
        _store(builder, _data(context, builder, signature.args[0], arguments[0]), index, arguments[2])
        return context.get_dummy_value()

    return types.void(array, row, lanes), generate


@intrinsic
def splat(typing: Any, number: Any) -> Any:
    """The same number in every lane."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        undefined = ir.Constant(_VECTOR, ir.Undefined)
        first = builder.insert_element(undefined, arguments[0], ir.Constant(ir.IntType(32), 0))
        mask = ir.Constant(ir.VectorType(ir.IntType(32), LANE_COUNT), [0] * LANE_COUNT)
        return builder.shuffle_vector(first, undefined, mask)

    return lanes(types.float64), generate


def _elementwise(count: int, build: Callable[..., Any]) -> Any:
    """An intrinsic of `count` lane blocks that gives one."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return build(builder, *arguments)

    # numba reads the number of arguments off the signature, so each has its own.
    if count == 1:
        return intrinsic(lambda typing, a: (lanes(lanes), generate))
    if count == 2:
        return intrinsic(lambda typing, a, b: (lanes(lanes, lanes), generate))
    if count == 3:
        return intrinsic(lambda typing, a, b, c: (lanes(lanes, lanes, lanes), generate))
    return intrinsic(lambda typing, a, b, c, d: (lanes(lanes, lanes, lanes, lanes), generate))


def _select_greater(builder: Any, a: Any, b: Any, yes: Any, no: Any) -> Any:
    return builder.select(builder.fcmp_ordered(">", a, b), yes, no)


sqrt = _elementwise(1, lambda builder, a: _call(builder, "sqrt", a))
absolute = _elementwise(1, lambda builder, a: _call(builder, "fabs", a))
exp = _elementwise(1, lambda builder, a: _call(builder, "exp", a))
maximum = _elementwise(2, lambda builder, a, b: _select_greater(builder, a, b, a, b))
fma = _elementwise(3, _fused_multiply_add)
where_greater = _elementwise(4, _select_greater)  # where a > b: yes, else no


@intrinsic
def largest(typing: Any, block: Any) -> Any:
    """The largest number of a lane block, as a float: whether anything is to be done in any lane."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        function = ir.FunctionType(ir.DoubleType(), [_VECTOR])
        name = f"llvm.vector.reduce.fmax.v{LANE_COUNT}f64"
        return builder.call(cgutils.get_or_insert_function(builder.module, function, name), arguments)

    return types.float64(lanes), generate


_ARITHMETIC = {
    operator.add: _elementwise(2, lambda builder, a, b: builder.fadd(a, b)),
    operator.sub: _elementwise(2, lambda builder, a, b: builder.fsub(a, b)),
    operator.mul: _elementwise(2, lambda builder, a, b: builder.fmul(a, b)),
    operator.truediv: _elementwise(2, lambda builder, a, b: builder.fdiv(a, b)),
}


def _give_operator(symbol: Any, operation: Any) -> None:
    @overload(symbol, strict=False)
    def _operator(a: Any, b: Any) -> Any:
        if a is lanes and b is lanes:
            return lambda a, b: operation(a, b)
        if a is lanes and isinstance(b, types.Float):
            return lambda a, b: operation(a, splat(b))
        if isinstance(a, types.Float) and b is lanes:
            return lambda a, b: operation(splat(a), b)
        return None


for _symbol, _operation in _ARITHMETIC.items():
    _give_operator(_symbol, _operation)


@intrinsic(prefer_literal=True)
def subtract_block_products(
    typing: Any, d: Any, sums: Any, target: Any, lefts: Any, left: Any, rights: Any, right: Any, count: Any
) -> Any:
    """sums[target] -= sum of left block @ right block transposed, over `count` consecutive pairs of d x d blocks.

    `target`, `left` and `right` are row numbers of the arrays (rows, 8) before them; a block is d * d rows, row by row.
    The innermost loop of the factorization: the block under way stays in registers, which only unrolled code can say.
    """
    if not isinstance(d, types.IntegerLiteral):
        return None
    size = d.literal_value

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        sum_data, left_data, right_data = (_data(context, builder, signature.args[k], arguments[k]) for k in (1, 3, 5))
        target_row, left_row, right_row, pair_count = (arguments[k] for k in (2, 4, 6, 7))

        def entry(first: Any, k: int) -> Any:
            return builder.add(first, ir.Constant(_INDEX, k))

        before = [_load(builder, sum_data, entry(target_row, k)) for k in range(size * size)]
        start = builder.block
        head, body, end = (builder.append_basic_block(name) for name in ("pairs", "pair", "pairs.end"))
        builder.branch(head)

        builder.position_at_end(head)
        pair = builder.phi(_INDEX)
        totals = [builder.phi(_VECTOR) for _ in range(size * size)]
        builder.cbranch(builder.icmp_signed("<", pair, pair_count), body, end)

        builder.position_at_end(body)
        offset = builder.mul(pair, ir.Constant(_INDEX, size * size))
        left_block, right_block = builder.add(left_row, offset), builder.add(right_row, offset)
        right_entries = [_load(builder, right_data, entry(right_block, k)) for k in range(size * size)]
        after = list(totals)
        for a in range(size):
            for c in range(size):
                negative = builder.fneg(_load(builder, left_data, entry(left_block, a * size + c)))
                for b in range(size):
                    k = a * size + b
                    after[k] = _fused_multiply_add(builder, negative, right_entries[b * size + c], after[k])
        following = builder.add(pair, ir.Constant(_INDEX, 1))
        builder.branch(head)

        pair.add_incoming(ir.Constant(_INDEX, 0), start)
        pair.add_incoming(following, body)
        for total, first, later in zip(totals, before, after, strict=True):
            total.add_incoming(first, start)
            total.add_incoming(later, body)
        builder.position_at_end(end)
        for k in range(size * size):
            _store(builder, sum_data, entry(target_row, k), totals[k])
        return context.get_dummy_value()

    rows = types.intp
    return types.void(d, sums, rows, lefts, rows, rights, rows, rows), generate
