"""The innermost loops of the band factor, spelled out for LLVM: four columns, or eight right-hand sides, at once.

As in `effects.lanes` the vectors are written as such, because LLVM can't know that columns of one array do not overlap.
A vector is 64 bytes of the band's number type along a column, or the eight right-hand sides of one unknown. Every
number is computed by the same operations in the same order on every machine with fused multiply-add.
"""

from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils

from springopt.effects.lanes import LANE_COUNT, intrinsic

VECTOR_BYTES = 64
_INDEX, _SHORT = ir.IntType(64), ir.IntType(32)


class _Vectors:
    """LLVM's vectors of `count` numbers of one kind, and the few operations the loops need."""

    def __init__(self, builder: Any, kind: Any, count: int) -> None:
        is_double = kind == types.float64
        self.builder, self.count, self.size = builder, count, 8 if is_double else 4
        self.element = ir.DoubleType() if is_double else ir.FloatType()
        self.type = ir.VectorType(self.element, count)
        signature = ir.FunctionType(self.type, [self.type] * 3)
        name = f"llvm.fmuladd.v{count}f{64 if is_double else 32}"
        self.fused = cgutils.get_or_insert_function(builder.module, signature, name)

    def at(self, data: Any, index: Any) -> Any:
        return self.builder.bitcast(self.builder.gep(data, [index]), self.type.as_pointer())

    def load(self, data: Any, index: Any) -> Any:
        value = self.builder.load(self.at(data, index))
        value.align = self.size
        return value

    def store(self, data: Any, index: Any, value: Any) -> None:
        self.builder.store(value, self.at(data, index)).align = self.size

    def splat(self, number: Any) -> Any:
        undefined = ir.Constant(self.type, ir.Undefined)
        first = self.builder.insert_element(undefined, number, ir.Constant(_SHORT, 0))
        mask = ir.Constant(ir.VectorType(_SHORT, self.count), [0] * self.count)
        return self.builder.shuffle_vector(first, undefined, mask)

    def number(self, data: Any, index: Any) -> Any:
        """One number in every place of a vector."""
        return self.splat(self.builder.load(self.builder.gep(data, [index])))

    def multiply_add(self, a: Any, b: Any, c: Any) -> Any:
        return self.builder.call(self.fused, [a, b, c])

    def zero(self) -> Any:
        return ir.Constant(self.type, [ir.Constant(self.element, 0.0)] * self.count)


def _data(context: Any, builder: Any, signature: Any, arguments: Any, k: int) -> Any:
    return context.make_array(signature.args[k])(context, builder, arguments[k]).data


def _plus(builder: Any, index: Any, k: int) -> Any:
    return builder.add(index, ir.Constant(_INDEX, k))


def _lane_row(builder: Any, row: Any) -> Any:
    return builder.mul(row, ir.Constant(_INDEX, LANE_COUNT))


def _count_up(builder: Any, count: Any, carried: list[Any], body: Callable[[Any, list[Any]], list[Any]]) -> list[Any]:
    """A loop over 0 .. count - 1 that carries values in registers; returns them as they leave it."""
    start = builder.block
    head, inside, end = (builder.append_basic_block(name) for name in ("head", "inside", "end"))
    builder.branch(head)
    builder.position_at_end(head)
    i = builder.phi(_INDEX)
    values = [builder.phi(value.type) for value in carried]
    builder.cbranch(builder.icmp_signed("<", i, count), inside, end)
    builder.position_at_end(inside)
    after = body(i, values)
    i.add_incoming(ir.Constant(_INDEX, 0), start)
    i.add_incoming(_plus(builder, i, 1), builder.block)
    for value, before, later in zip(values, carried, after, strict=True):
        value.add_incoming(before, start)
        value.add_incoming(later, builder.block)
    builder.branch(head)
    builder.position_at_end(end)
    return values


@intrinsic
def add_scaled(typing: Any, target: Any, at: Any, source: Any, source_at: Any, factor: Any) -> Any:
    """target[at:] += factor * source[source_at:], 64 bytes of them."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        v = _Vectors(builder, target.dtype, VECTOR_BYTES // (8 if target.dtype == types.float64 else 4))
        into, out_of = (_data(context, builder, signature, arguments, k) for k in (0, 2))
        old, new = v.load(into, arguments[1]), v.load(out_of, arguments[3])
        v.store(into, arguments[1], v.multiply_add(v.splat(arguments[4]), new, old))
        return context.get_dummy_value()

    return types.void(target, types.intp, source, types.intp, target.dtype), generate


@intrinsic(prefer_literal=True)
def eliminate(typing: Any, pivots: Any, band: Any, at: Any, pivot_at: Any, stride: Any, factors: Any, k: Any) -> Any:
    """64 bytes of four columns from `at` on, += those of `pivots` columns from `pivot_at` on times their factors.

    Columns are `stride` apart in `band`; `factors` (pivots, rows), four of each row from its entry `k` on.
    """
    if not isinstance(pivots, types.IntegerLiteral):
        return None

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        v = _Vectors(builder, band.dtype, VECTOR_BYTES // (8 if band.dtype == types.float64 else 4))
        data, table = (_data(context, builder, signature, arguments, k) for k in (1, 5))
        shape = cgutils.unpack_tuple(
            builder, context.make_array(signature.args[5])(context, builder, arguments[5]).shape, 2
        )
        _, _, at, pivot_at, stride, _, factor_at = arguments
        columns = [at]
        for _ in range(3):
            columns.append(builder.add(columns[-1], stride))
        sums = [v.load(data, column) for column in columns]
        for _ in range(pivots.literal_value):
            entries = v.load(data, pivot_at)
            for c in range(4):
                factor = v.number(table, _plus(builder, factor_at, c))
                sums[c] = v.multiply_add(factor, entries, sums[c])
            pivot_at, factor_at = builder.add(pivot_at, stride), builder.add(factor_at, shape[1])
        for column, total in zip(columns, sums, strict=True):
            v.store(data, column, total)
        return context.get_dummy_value()

    index = types.intp
    return types.void(pivots, band, index, index, index, factors, index), generate


@intrinsic(prefer_literal=True)
def subtract_columns(
    typing: Any, columns: Any, x: Any, row: Any, count: Any, band: Any, at: Any, stride: Any, known: Any
) -> Any:
    """x[row + i] -= sum over the columns q of band[at + i + q * stride] * x[known + q], for i < count; x (rows, 8)."""
    if not isinstance(columns, types.IntegerLiteral):
        return None

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        v = _Vectors(builder, x.dtype, LANE_COUNT)
        sides, data = (_data(context, builder, signature, arguments, k) for k in (1, 4))
        _, _, row, count, _, at, stride, known = arguments
        values, begins = [], [at]
        for q in range(columns.literal_value):
            values.append(builder.fneg(v.load(sides, _lane_row(builder, _plus(builder, known, q)))))
            begins.append(builder.add(begins[-1], stride))

        def body(i: Any, _: list[Any]) -> list[Any]:
            here = _lane_row(builder, builder.add(row, i))
            total = v.load(sides, here)
            for value, begin in zip(values, begins, strict=False):
                total = v.multiply_add(v.number(data, builder.add(begin, i)), value, total)
            v.store(sides, here, total)
            return []

        _count_up(builder, count, [], body)
        return context.get_dummy_value()

    index = types.intp
    return types.void(columns, x, index, index, band, index, index, index), generate


@intrinsic(prefer_literal=True)
def dot_columns(
    typing: Any, columns: Any, sums: Any, x: Any, row: Any, count: Any, band: Any, at: Any, stride: Any
) -> Any:
    """sums[q] = sum over i < count of band[at + i + q * stride] * x[row + i]; x and sums have eight columns."""
    if not isinstance(columns, types.IntegerLiteral):
        return None

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        v = _Vectors(builder, x.dtype, LANE_COUNT)
        totals, sides, data = (_data(context, builder, signature, arguments, k) for k in (1, 2, 5))
        _, _, _, row, count, _, at, stride = arguments
        begins = [at]
        for _ in range(columns.literal_value - 1):
            begins.append(builder.add(begins[-1], stride))

        def body(i: Any, before: list[Any]) -> list[Any]:
            value = v.load(sides, _lane_row(builder, builder.add(row, i)))
            return [
                v.multiply_add(v.number(data, builder.add(begin, i)), value, total)
                for begin, total in zip(begins, before, strict=True)
            ]

        for q, total in enumerate(_count_up(builder, count, [v.zero() for _ in begins], body)):
            v.store(totals, ir.Constant(_INDEX, q * LANE_COUNT), total)
        return context.get_dummy_value()

    index = types.intp
    return types.void(columns, sums, x, index, index, band, index, index), generate
