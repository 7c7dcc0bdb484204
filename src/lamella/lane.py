"""A vector of ``WIDTH`` numbers for compiled kernels, one for each of as many elements that are computed together.

Numba maps ``Lane`` to LLVM's ``<WIDTH x double>``. An expression in + - * / and :func:`sqrt` written for numbers thus runs for
several elements at once; a number combined with a lane counts for all of them. Lanes live in kernels only: they are loaded from
and stored to consecutive entries of an array without gaps, of float64, or of float32 or int16, which takes a half or a quarter
of the memory: what is read becomes float64, what is written is rounded, to int16 towards zero. Where single precision is enough,
``SingleLane`` holds twice as many numbers, as float32.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from typing import Any, NamedTuple, cast

import numpy as np
from llvmlite import binding, ir
from numba import extending
from numba.core import cgutils, errors, types
from numba.core.datamodel.models import PrimitiveModel
from numba.core.typing import templates
from numba.extending import lower_builtin, overload, register_model

from lamella._compiler import FIRST
from lamella.roles import Floats

# Numba's decorators change signatures in ways that type checkers do not follow.
intrinsic = cast("Callable[[Callable[..., Any]], Callable[..., Any]]", extending.intrinsic)
infer_global = cast("Any", templates.infer_global)

WIDTH = 8 if binding.get_host_cpu_features().get("avx512f") else 4
"""Numbers in a lane: what one register of this processor holds, or four. Wider lanes run out of registers: on a processor with
256 bits, tangent and factorisation take a third more time. The layout of element arrays follows the width."""

CACHE_LINE = 8
"""Numbers in a cache line of 64 bytes."""

_VECTOR = ir.VectorType(ir.DoubleType(), WIDTH)
_FLAGS = ("contract", "nsz")
_BINARY = {operator.add: "fadd", operator.sub: "fsub", operator.mul: "fmul", operator.truediv: "fdiv"}


def aligned(size: int) -> Floats:
    """A flat array of zeros whose first entry starts a cache line, so that no lane lies across two."""
    raw = np.zeros(size + CACHE_LINE)
    first = -(raw.ctypes.data // raw.itemsize) % CACHE_LINE
    return raw[first : first + size]


class LaneType(types.Type):
    """Numba's type of a vector of numbers, by its name and LLVM's type of it."""

    def __init__(self, name: str, vector: Any) -> None:
        super().__init__(name=name)
        self.vector = vector


Lane = LaneType("Lane", _VECTOR)
SingleLane = LaneType("SingleLane", ir.VectorType(ir.FloatType(), 2 * WIDTH))


@register_model(LaneType)
class LaneModel(PrimitiveModel):
    """A lane is held in one vector register."""

    def __init__(self, dmm: Any, fe_type: LaneType) -> None:
        super().__init__(dmm, fe_type, fe_type.vector)


def _spread(builder: Any, number: Any, vector: Any = _VECTOR) -> Any:
    """The same number in all places."""
    if number.type != vector.element:
        number = builder.fptrunc(number, vector.element)
    one = builder.insert_element(ir.Constant(vector, ir.Undefined), number, ir.Constant(ir.IntType(32), 0))
    zeros = ir.Constant(ir.VectorType(ir.IntType(32), vector.count), [0] * vector.count)
    return builder.shuffle_vector(one, ir.Constant(vector, ir.Undefined), zeros)


def _as_lane(builder: Any, value: Any, vector: Any = _VECTOR) -> Any:
    return value if value.type == vector else _spread(builder, value, vector)


def _register_binary(function: Any, instruction: str) -> None:
    """Teach Numba one operator for lane with lane and lane with number."""
    operands = [pair for lane in (Lane, SingleLane) for pair in ((lane, lane), (lane, types.float64), (types.float64, lane))]

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        left, right = (_as_lane(builder, value, sig.return_type.vector) for value in args)
        return getattr(builder, instruction)(left, right, flags=_FLAGS)

    cases = [templates.signature(next(x for x in pair if isinstance(x, LaneType)), *pair) for pair in operands]
    infer_global(function)(type(f"Lane_{instruction}", (templates.ConcreteTemplate,), {"cases": cases, "metadata": FIRST}))
    for pair in operands:
        lower_builtin(function, *pair)(lower)


for _function, _instruction in _BINARY.items():
    _register_binary(_function, _instruction)


@infer_global(operator.neg)
class _LaneNegation(templates.ConcreteTemplate):
    cases = [templates.signature(Lane, Lane)]  # noqa: RUF012 - Numba's own form of a template


@lower_builtin(operator.neg, Lane)
def _lower_negation(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    return builder.fneg(args[0], flags=_FLAGS)


@intrinsic
def _lane_sqrt(typing_context: Any, value: types.Type) -> Any:
    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        function_type = ir.FunctionType(_VECTOR, [_VECTOR])
        return builder.call(cgutils.get_or_insert_function(builder.module, function_type, f"llvm.sqrt.v{WIDTH}f64"), args)

    return Lane(Lane), generate


def sqrt(value: Any) -> Any:
    """Square root of a number or array; in kernels also of a lane."""
    return np.sqrt(value)


@overload(sqrt, jit_options={"forceinline": True})
def _overload_sqrt(value):  # noqa: ANN001, ANN202 - Numba compares this signature with that of the implementation
    if isinstance(value, LaneType):
        return lambda value: _lane_sqrt(value)
    return lambda value: math.sqrt(value)


@intrinsic
def _lane_chosen(typing_context: Any, condition: types.Type, one: types.Type, other: types.Type) -> Any:
    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        positive = builder.fcmp_ordered(">", args[0], ir.Constant(_VECTOR, [0.0] * WIDTH))
        return builder.select(positive, _as_lane(builder, args[1]), _as_lane(builder, args[2]))

    return Lane(Lane, one, other), generate


def chosen(condition: Any, one: Any, other: Any) -> Any:
    """``one`` where the condition is above zero, else ``other``; in kernels also of lanes. Both are computed."""
    return np.where(condition > 0.0, one, other)


@overload(chosen, jit_options={"forceinline": True})
def _overload_chosen(condition, one, other):  # noqa: ANN001, ANN202
    if isinstance(condition, LaneType):
        return lambda condition, one, other: _lane_chosen(condition, one, other)
    return lambda condition, one, other: one if condition > 0.0 else other


@intrinsic
def _lane_power(typing_context: Any, base: types.Type, exponent: types.Type) -> Any:
    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        double, result = ir.DoubleType(), ir.Constant(_VECTOR, ir.Undefined)
        power = cgutils.get_or_insert_function(builder.module, ir.FunctionType(double, [double, double]), "llvm.pow.f64")
        for i in range(WIDTH):
            place = ir.Constant(ir.IntType(32), i)
            one = builder.call(power, [builder.extract_element(args[0], place), args[1]])
            result = builder.insert_element(result, one, place)
        return result

    return Lane(Lane, types.float64), generate


def power(base: Any, exponent: float) -> Any:
    """``base ** exponent``; in kernels also of a lane."""
    return base**exponent


@overload(power, jit_options={"forceinline": True})
def _overload_power(base, exponent):  # noqa: ANN001, ANN202
    if isinstance(base, LaneType):
        return lambda base, exponent: _lane_power(base, exponent)
    return lambda base, exponent: base**exponent


class _Stored(NamedTuple):
    """How the numbers of an array become those of a lane, and the other way round.

    Args:
        number: LLVM's type of a number in the array.
        align: bytes of it.
        widen, narrow: instructions of the builder; empty where the numbers are those of a lane.
    """

    number: Any
    align: int
    widen: str = ""
    narrow: str = ""


_STORED = {
    types.float64: _Stored(ir.DoubleType(), 8),
    types.float32: _Stored(ir.FloatType(), 4, "fpext", "fptrunc"),
    types.int16: _Stored(ir.IntType(16), 2, "sitofp", "fptosi"),
}
"""Arrays that lanes are loaded from and stored to, by the type of their numbers."""


def _flat(array: Any) -> Any:
    if array.layout != "C":
        raise errors.TypingError(f"a kernel takes an array without gaps, not {array}")
    return array


def _vector_pointer(context: Any, builder: Any, array_type: Any, array: Any, index: Any, stride: int, count: int) -> Any:
    data = cgutils.create_struct_proxy(array_type)(context, builder, array).data
    vector = ir.VectorType(_STORED[array_type.dtype].number, count)
    return builder.bitcast(builder.gep(data, [builder.mul(index, ir.Constant(index.type, stride))]), vector.as_pointer())


def _loader(stride: int, vector: Any = _VECTOR) -> Any:
    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        stored = _STORED[sig.args[0].dtype]
        pointer = _vector_pointer(context, builder, sig.args[0], args[0], args[1], stride, vector.count)
        found = builder.load(pointer, align=stored.align)
        return found if found.type == vector else getattr(builder, stored.widen)(found, vector)

    return generate


def _storer(stride: int, vector: Any = _VECTOR) -> Any:
    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        stored, value = _STORED[sig.args[0].dtype], _as_lane(builder, args[2], vector)
        if stored.number != vector.element:
            value = getattr(builder, stored.narrow)(value, ir.VectorType(stored.number, vector.count))
        pointer = _vector_pointer(context, builder, sig.args[0], args[0], args[1], stride, vector.count)
        builder.store(value, pointer, align=stored.align)
        return context.get_dummy_value()

    return generate


@intrinsic
def load(typing_context: Any, array: types.Type, number: types.Type) -> Any:
    """``load(array, k)``: lane k of a flat contiguous float64 array, its entries WIDTH k ... WIDTH (k + 1) - 1."""
    return Lane(_flat(array), types.intp), _loader(WIDTH)


@intrinsic
def store(typing_context: Any, array: types.Type, number: types.Type, value: types.Type) -> Any:
    """``store(array, k, lane)``: write lane k; a number is written to all its entries."""
    return types.none(_flat(array), types.intp, value), _storer(WIDTH)


@intrinsic
def load_at(typing_context: Any, array: types.Type, index: types.Type) -> Any:
    """``load_at(array, index)``: the lane of the entries index ... index + WIDTH - 1."""
    return Lane(_flat(array), types.intp), _loader(1)


@intrinsic
def number_at(typing_context: Any, array: Any, index: types.Type) -> Any:
    """``number_at(array, index)``: array[index] for an index that is not negative, of an array without gaps.

    Numba asks of every index whether it counts from the end, which costs as much as two or three multiplications of lanes.
    """

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        data = cgutils.create_struct_proxy(sig.args[0])(context, builder, args[0]).data
        number = builder.load(builder.gep(data, [args[1]]))
        return getattr(builder, widen)(number, ir.DoubleType()) if widen else number

    widen = _STORED[array.dtype].widen if array.dtype in _STORED else ""
    return (types.float64 if widen else array.dtype)(_flat(array), types.intp), generate


@intrinsic
def fetch_at(typing_context: Any, array: types.Type, index: types.Type) -> Any:
    """``fetch_at(array, index)``: bring an entry near, which may lie outside the array, as it will be read soon."""

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        data = cgutils.create_struct_proxy(sig.args[0])(context, builder, args[0]).data
        number, pointer = ir.IntType(32), ir.IntType(8).as_pointer()
        function_type = ir.FunctionType(ir.VoidType(), [pointer, number, number, number])
        fetch = cgutils.get_or_insert_function(builder.module, function_type, "llvm.prefetch.p0i8")
        place = builder.bitcast(builder.gep(data, [args[1]]), pointer)
        builder.call(fetch, [place, *(ir.Constant(number, x) for x in (0, 3, 1))])  # to read, to the first level, data
        return context.get_dummy_value()

    return types.none(array, types.intp), generate


@intrinsic
def put_at(typing_context: Any, array: Any, index: types.Type, number: types.Type) -> Any:
    """``put_at(array, index, number)``: array[index] = number, as :func:`number_at` reads it."""

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        data = cgutils.create_struct_proxy(sig.args[0])(context, builder, args[0]).data
        builder.store(args[2], builder.gep(data, [args[1]]))
        return context.get_dummy_value()

    return types.none(_flat(array), types.intp, array.dtype), generate


@intrinsic
def store_at(typing_context: Any, array: types.Type, index: types.Type, value: types.Type) -> Any:
    """``store_at(array, index, lane)``: write a lane, or a number for all, to the entries index ... index + WIDTH - 1."""
    return types.none(_flat(array), types.intp, value), _storer(1)


@intrinsic
def load_singles(typing_context: Any, array: types.Type, index: types.Type) -> Any:
    """``load_singles(array, index)``: the lane of 2 WIDTH single numbers from an index on, of float32 or int16."""
    return SingleLane(array, types.intp), _loader(1, SingleLane.vector)


@intrinsic
def store_singles(typing_context: Any, array: types.Type, index: types.Type, value: types.Type) -> Any:
    """``store_singles(array, index, lane)``: write a lane of single numbers to an array of float32."""
    return types.none(array, types.intp, value), _storer(1, SingleLane.vector)


@intrinsic
def spread_singles(typing_context: Any, number: types.Type) -> Any:
    """``spread_singles(number)``: a lane of single numbers holding the same one in all places."""

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return _spread(builder, args[0], SingleLane.vector)

    return SingleLane(types.float64), generate


@intrinsic
def spread(typing_context: Any, number: types.Type) -> Any:
    """``spread(number)``: a lane holding the same number in all places."""

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return _spread(builder, args[0])

    return Lane(types.float64), generate


@intrinsic
def total(typing_context: Any, value: types.Type) -> Any:
    """``total(lane)``: the sum of the numbers of a lane."""

    def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        vector = sig.args[0].vector
        number, double = vector.element, ir.DoubleType()
        function_type = ir.FunctionType(number, [number, vector])
        kind = f"v{vector.count}f{64 if number == double else 32}"
        add = cgutils.get_or_insert_function(builder.module, function_type, f"llvm.vector.reduce.fadd.{kind}")
        found = builder.call(add, [ir.Constant(number, 0.0), args[0]], fastmath=("reassoc", *_FLAGS))
        return found if number == double else builder.fpext(found, double)

    return types.float64(value), generate
