"""SIMD vectors for kernels (Numba): operations on eight or four numbers.

Numba rarely vectorises a loop over eight numbers. This module provides SIMD
vectors of eight or four numbers, called lanes. An operation on eight lanes is
one instruction, or two if the processor's registers hold four numbers. Kernels
use lanes in the same expressions as numbers, and a scalar operand is broadcast.
The result in each lane equals that of scalar code to the last bit.

A comparison of lanes returns a mask, which has one boolean for each lane.
`where` and `places_of` take such masks.
"""

import operator
from collections.abc import Callable
from typing import Any, cast

from llvmlite import ir
from numba import types
from numba.core.typing.templates import (
    AbstractTemplate,
    infer_global,
    signature,
)
from numba.extending import (
    intrinsic,
    lower_builtin,
    models,
    register_model,
)

from remosplat_drake.base.kernels import helper

_built_in = cast(Callable[..., Any], intrinsic)
"""Numba's decorator `intrinsic`. Callers of a decorated function omit its first
parameter, `typing`."""

WIDTH, FEW = 8, 4
"""Numbers of lanes in a vector: usually eight, and four for data that rarely
fill eight lanes."""

_NUMBER, _TRUTH = ir.DoubleType(), ir.IntType(1)
_WHOLE, _PLACE = ir.IntType(64), ir.IntType(32)


class _Vector(types.Type):
    """Numba's type of several numbers or booleans."""

    def __init__(self, name: str, element: ir.Type, width: int):
        self.width = width
        self.vector = ir.VectorType(element, width)
        super().__init__(f"{name}{width}")


_LANES = {width: _Vector("Lanes", _NUMBER, width) for width in (WIDTH, FEW)}
_MASKS = {width: _Vector("Mask", _TRUTH, width) for width in (WIDTH, FEW)}


@register_model(_Vector)
class _VectorModel(models.PrimitiveModel):
    def __init__(self, manager, kind):
        super().__init__(manager, kind, kind.vector)


def _is_lanes(kind) -> bool:
    return kind in _LANES.values()


def _is_number(kind) -> bool:
    return _is_lanes(kind) or isinstance(kind, types.Number)


def _width_of(kinds) -> int:
    """Returns the number of lanes of operands; 0 if all are scalars."""
    return max(kind.width if isinstance(kind, _Vector) else 0 for kind in kinds)


def _numbers(width: int) -> Any:
    """Returns the type of a vector of numbers; a scalar's if `width` is 0."""
    return _LANES.get(width, types.float64)


def _spread(context, builder, kind, value, width):
    """Broadcasts a number or boolean to `width` lanes, unless `width` is 0."""
    if isinstance(kind, _Vector):
        return value
    element = _TRUTH
    if not isinstance(kind, types.Boolean):
        element = _NUMBER
        value = context.cast(builder, value, kind, types.float64)
    if not width:
        return value
    none = ir.Constant(ir.VectorType(element, width), ir.Undefined)
    first = builder.insert_element(none, value, _PLACE(0))
    equal = ir.Constant(ir.VectorType(_PLACE, width), [0] * width)
    return builder.shuffle_vector(first, none, equal)


def _spread_all(context, builder, kinds, values):
    width = _width_of(kinds)
    return [
        _spread(context, builder, kind, value, width)
        for kind, value in zip(kinds, values, strict=True)
    ]


_SINGLE = (types.Number, types.Boolean)


def _define(function, operands, results, build) -> None:
    """Defines an operator of lanes or masks; some operands may be scalars."""

    class _Operator(AbstractTemplate):
        key = function

        def generic(self, args, kws):
            operand = operands.get(_width_of(args))
            fits = all(a == operand or isinstance(a, _SINGLE) for a in args)
            if operand is None or not fits:
                return None
            return signature(results[operand.width], *args)

    infer_global(function, types.Function(_Operator))

    def lower(context, builder, signature, values):
        values = _spread_all(context, builder, signature.args, values)
        return build(builder, *values)

    if function in (operator.neg, operator.invert):
        lower_builtin(function, _Vector)(lower)
        return
    lower_builtin(function, _Vector, _Vector)(lower)
    for single in _SINGLE:
        lower_builtin(function, _Vector, single)(lower)
        lower_builtin(function, single, _Vector)(lower)


def _compare(sign):
    """Generates an ordered comparison, which is false if an operand is NaN."""
    return lambda builder, a, b: builder.fcmp_ordered(sign, a, b)


_define(operator.add, _LANES, _LANES, ir.IRBuilder.fadd)
_define(operator.sub, _LANES, _LANES, ir.IRBuilder.fsub)
_define(operator.mul, _LANES, _LANES, ir.IRBuilder.fmul)
_define(operator.truediv, _LANES, _LANES, ir.IRBuilder.fdiv)
_define(operator.neg, _LANES, _LANES, ir.IRBuilder.fneg)
_define(operator.lt, _LANES, _MASKS, _compare("<"))
_define(operator.le, _LANES, _MASKS, _compare("<="))
_define(operator.gt, _LANES, _MASKS, _compare(">"))
_define(operator.ge, _LANES, _MASKS, _compare(">="))
_define(operator.and_, _MASKS, _MASKS, ir.IRBuilder.and_)
_define(operator.or_, _MASKS, _MASKS, ir.IRBuilder.or_)
_define(operator.invert, _MASKS, _MASKS, ir.IRBuilder.not_)


def _of_numbers(build):
    """Returns type and code generator of a function of scalars or lanes."""

    def type_and_lower(*kinds):
        if not all(map(_is_number, kinds)):
            return None
        result = _numbers(_width_of(kinds))

        def lower(context, builder, signature, values):
            return build(builder, *_spread_all(context, builder, kinds, values))

        return result(*kinds), lower

    return type_and_lower


def _call(name):
    """Generates a call of an LLVM intrinsic."""

    def build(builder, value):
        vector = isinstance(value.type, ir.VectorType)
        kind = f"v{value.type.count}f64" if vector else "f64"
        function = builder.module.declare_intrinsic(
            f"{name}.{kind}", (), ir.FunctionType(value.type, [value.type])
        )
        return builder.call(function, [value])

    return build


def _choose(sign):
    def build(builder, a, b):
        return builder.select(builder.fcmp_ordered(sign, a, b), a, b)

    return build


_root = _of_numbers(_call("llvm.sqrt"))
_magnitude = _of_numbers(_call("llvm.fabs"))
_round_up = _of_numbers(_call("llvm.ceil"))
_round_down = _of_numbers(_call("llvm.floor"))
_greatest = _of_numbers(_choose(">"))
_least = _of_numbers(_choose("<"))


@_built_in
def root(typing, x):
    """Returns the square root of a number, or of each lane of a vector."""
    return _root(x)


@_built_in
def magnitude(typing, x):
    """Returns the absolute value of a number, or of each lane of a vector."""
    return _magnitude(x)


@_built_in
def round_up(typing, x):
    """Rounds a number, or each lane, up to an integer; returns floats."""
    return _round_up(x)


@_built_in
def round_down(typing, x):
    """Rounds a number, or each lane, down to an integer; returns floats."""
    return _round_down(x)


@_built_in
def greatest(typing, a, b):
    """Returns the greater of a and b, in each lane; b if one of them is NaN."""
    return _greatest(a, b)


@_built_in
def least(typing, a, b):
    """Returns the lesser of a and b, in each lane; b if one of them is NaN."""
    return _least(a, b)


@_built_in
def _times_power_of_two(typing, x, shifted):
    """Returns x * 2^n for numbers or lanes, with n = `shifted` - `_SHIFT`."""
    if x != shifted or not _is_number(x):
        return None

    def add_to_exponent(context, builder, signature, values):
        kind, exponent = _WHOLE, 52
        if _is_lanes(x):
            kind, exponent = ir.VectorType(_WHOLE, x.width), [52] * x.width
        bits, n = (builder.bitcast(value, kind) for value in values)
        n = builder.shl(n, ir.Constant(kind, exponent))
        return builder.bitcast(builder.add(bits, n), values[0].type)

    return x(x, shifted), add_to_exponent


_SHIFT = 1.5 * 2.0**52
"""Constant for rounding. If it is added to a number, the lowest bits of the sum
contain the rounded number."""

_LOG2_E = 1.4426950408889634
_LN_2 = (0.693147180369123816490, 1.90821492927058770002e-10)
"""The natural logarithm of 2 as a sum of two numbers. The first number has so
few digits that its product with any exponent is exact."""

_LEAST = -700.0
"""Smallest power of 2 in the results of `exponential`. Smaller powers are
clamped to it, since the result is nearly zero."""


@helper
def exponential(x):
    """Returns e^x, where x <= 0 is a number or a vector of lanes."""
    x = greatest(x, _LEAST)
    shifted = x * _LOG2_E + _SHIFT
    n = shifted - _SHIFT
    r = (x - n * _LN_2[0]) - n * _LN_2[1]
    return _times_power_of_two(_series(r), shifted)


@helper
def _series(r):
    """Returns e^x by Taylor's series, for |x| <= ln(2) / 2."""
    r2 = r * r
    r4 = r2 * r2
    low = (1.0 + r) + r2 * (0.5 + r * (1 / 6))
    middle = (1 / 24 + r * (1 / 120)) + r2 * (1 / 720 + r * (1 / 5040))
    high = (1 / 40320 + r * (1 / 362880)) + r2 * (
        1 / 3628800 + r * (1 / 39916800)
    )
    highest = 1 / 479001600 + r * (1 / 6227020800)
    return low + r4 * (middle + r4 * (high + r4 * highest))


@_built_in
def where(typing, condition, a, b):
    """Selects a where a condition holds, and b elsewhere.

    Args:
        typing: Numba's typing context; callers omit it.
        condition: A boolean or a mask.
        a: A number or lanes.
        b: A number or lanes.
    """
    if not (_is_number(a) and _is_number(b)):
        return None
    width = _width_of((condition, a, b))
    result = _numbers(width)

    def choose(context, builder, signature, values):
        chosen = (
            _spread(context, builder, kind, value, width)
            for kind, value in zip((a, b), values[1:], strict=True)
        )
        return builder.select(values[0], *chosen)

    return result(condition, a, b), choose


@_built_in
def in_all(typing, x):
    """Returns a vector in which all lanes contain the number x."""

    def spread(context, builder, signature, values):
        return _spread(context, builder, x, values[0], WIDTH)

    return _LANES[WIDTH](x), spread


@_built_in
def first_lanes(typing, n, lanes):
    """Returns a mask with the width of `lanes`, true in the first n lanes."""

    def compare(context, builder, signature, values):
        most = context.cast(builder, values[0], n, types.float64)
        most = _spread(context, builder, types.float64, most, lanes.width)
        counting = [float(i) for i in range(lanes.width)]
        counting = ir.Constant(lanes.vector, counting)
        return builder.fcmp_ordered("<", counting, most)

    return _MASKS[lanes.width](n, lanes), compare


@_built_in
def greatest_of(typing, lanes):
    """Returns the greatest number in the lanes, which must not contain NaN."""
    if not _is_lanes(lanes):
        return None

    def fold(context, builder, signature, values):
        (value,), width = values, lanes.width
        while width > 1:
            width //= 2
            lower, upper = range(width), range(width, 2 * width)
            kind = ir.VectorType(_PLACE, width)
            value = _choose(">")(
                builder,
                builder.shuffle_vector(value, value, kind(list(lower))),
                builder.shuffle_vector(value, value, kind(list(upper))),
            )
        return builder.extract_element(value, _PLACE(0))

    return types.float64(lanes), fold


@_built_in
def lane_of(typing, lanes, place):
    """Returns the number in one lane, by the lane's index."""
    if not (_is_lanes(lanes) and isinstance(place, types.Integer)):
        return None

    def extract(context, builder, signature, values):
        return builder.extract_element(*values)

    return types.float64(lanes, place), extract


@_built_in
def places_of(typing, mask):
    """Converts a mask to an integer, whose bit i is set if lane i is true."""

    def bits(context, builder, signature, values):
        as_bits = builder.bitcast(values[0], ir.IntType(mask.width))
        return builder.zext(as_bits, _WHOLE)

    return types.int64(mask), bits


@_built_in
def lanes_from(typing, array, place):
    """Reads eight consecutive numbers of an array into lanes.

    Args:
        typing: Numba's typing context; callers omit it.
        array: Contiguous array of single or double precision.
        place: Index of the first number in the flattened array.
    """
    return _read(array, WIDTH)


@_built_in
def few_lanes_from(typing, array, place):
    """Reads four consecutive numbers of an array into lanes."""
    return _read(array, FEW)


def _is_plain(array) -> bool:
    """Whether an array is contiguous."""
    return isinstance(array, types.Array) and array.layout == "C"


def _read(array, width):
    if not _is_plain(array):
        return None
    result = _LANES[width]

    def load(context, builder, signature, values):
        at = _address(context, builder, signature, values, width)
        numbers = builder.load(at)
        numbers.align = array.dtype.bitwidth // 8
        if array.dtype == types.float32:
            numbers = builder.fpext(numbers, result.vector)
        return numbers

    return result(array, types.int64), load


@_built_in
def columns_of(typing, array, places):
    """Reads eight rows of an array, and returns their columns as lanes.

    Args:
        typing: Numba's typing context; callers omit it.
        array: Array of double precision, shape (n, 16).
        places: Indices of the rows. Only the first eight indices are used.

    Returns:
        Sixteen vectors of eight lanes, one for each column.
    """
    if not (_is_plain(array) and _is_plain(places)):
        return None
    result = types.UniTuple(_LANES[WIDTH], 2 * WIDTH)
    vector = _LANES[WIDTH].vector

    def load(context, builder, signature, values):
        data, numbers = (
            context.make_array(kind)(context, builder, value).data
            for kind, value in zip((array, places), values, strict=True)
        )
        data = builder.bitcast(data, vector.as_pointer())
        halves = [], []
        for i in range(WIDTH):
            number = builder.load(builder.gep(numbers, [_WHOLE(i)]))
            first = builder.mul(number, _WHOLE(2))
            for k, half in enumerate(halves):
                at = builder.gep(data, [builder.add(first, _WHOLE(k))])
                half.append(builder.load(at, align=8))
        columns = [c for half in halves for c in _transposed(builder, half)]
        return context.make_tuple(builder, result, columns)

    return result(array, places), load


def _transposed(builder, rows):
    """Transposes eight vectors that are rows into vectors that are columns."""
    for step in (1, 2, 4):
        upper = [j - step + WIDTH if j & step else j for j in range(WIDTH)]
        lower = [j + WIDTH if j & step else j + step for j in range(WIDTH)]
        for i in range(WIDTH):
            if not i & step:
                pair = rows[i], rows[i + step]
                for k, order in ((i, upper), (i + step, lower)):
                    order = ir.Constant(ir.VectorType(_PLACE, WIDTH), order)
                    rows[k] = builder.shuffle_vector(*pair, order)
    return rows


@_built_in
def write_lanes(typing, array, place, lanes):
    """Writes lanes to consecutive elements of an array."""
    if not (_is_plain(array) and _is_lanes(lanes)):
        return None

    def store(context, builder, signature, values):
        at = _address(context, builder, signature, values, lanes.width)
        builder.store(values[2], at).align = 8
        return context.get_dummy_value()

    return types.void(array, types.int64, lanes), store


def _address(context, builder, signature, values, width):
    kind = signature.args[0]
    array = context.make_array(kind)(context, builder, values[0])
    at = builder.gep(array.data, [values[1]])
    number = ir.FloatType() if kind.dtype == types.float32 else _NUMBER
    return builder.bitcast(at, ir.VectorType(number, width).as_pointer())


@_built_in
def lowest_bit(typing, bits):
    """Returns the index of the lowest bit of an integer that is set.

    Args:
        typing: Numba's typing context; callers omit it.
        bits: An integer that is not 0.
    """

    def place(context, builder, signature, values):
        return builder.cttz(values[0], _TRUTH(1))

    return types.int64(bits), place
