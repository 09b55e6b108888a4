"""Finds the children of a node that are near a point, with SIMD (Numba).

Numba rarely vectorises a loop over eight children. This module generates code
for vectors of eight numbers. The compiler translates each operation to one
instruction, or to two if the processor's registers hold four numbers.
"""

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from remosplat_drake.base.kernels import helper
from remosplat_drake.oracle.kernels.wide_tree import ROWS, WIDTH

_VECTOR = ir.VectorType(ir.FloatType(), WIDTH)
_NONE = ir.Constant(_VECTOR, ir.Undefined)
_FIRST = ir.Constant(ir.VectorType(ir.IntType(32), WIDTH), [0] * WIDTH)

_SLACK = np.float32(1.0 + 1e-5)
"""Bound of the relative rounding error of a squared distance in single
precision."""


@helper
def node_address(wide, node) -> int:
    """Returns the memory address of a node's boxes.

    Args:
        wide: Boxes of the wide hierarchy, which `widen` returns.
        node: Number of the node.
    """
    return wide.ctypes.data + 4 * ROWS * WIDTH * node


@helper
def around(p):
    """Rounds three coordinates to single precision, both down and up.

    Args:
        p: The coordinates.

    Returns:
        For each coordinate, a number that is not greater and a number that is
        not smaller.
    """
    down, up = np.float32(-np.inf), np.float32(np.inf)
    x, y, z = np.float32(p[0]), np.float32(p[1]), np.float32(p[2])
    return (
        np.nextafter(x, down),
        np.nextafter(x, up),
        np.nextafter(y, down),
        np.nextafter(y, up),
        np.nextafter(z, down),
        np.nextafter(z, up),
    )


@helper
def raised(limit):
    """Rounds a limit of squared distances up to single precision.

    Args:
        limit: The limit [m^2].
    """
    return np.float32(limit) * _SLACK


@helper
def lowered(floor):
    """Rounds the height of a floor down to single precision.

    Args:
        floor: The height [m].
    """
    return np.nextafter(np.float32(floor), np.float32(-np.inf))


@intrinsic
def near_children(
    typing, address, x, x_above, y, y_above, z, z_above, limit, floor, squares
):
    """Finds the children whose boxes are near a point.

    Args:
        typing: Numba's typing context.
        address: Address of the node's boxes; see `node_address`.
        x: The point's x, rounded down; see `around`.
        x_above: The point's x, rounded up.
        y: The point's y, rounded down.
        y_above: The point's y, rounded up.
        z: The point's z, rounded down.
        z_above: The point's z, rounded up.
        limit: Limit of squared distances, rounded by `raised` [m^2].
        floor: Least height of a child, rounded by `lowered` [m].
        squares: Output: the squared distances of the children's boxes from the
            point, eight numbers in single precision [m^2].

    Returns:
        An integer with a bit for each child. The bit is 1 if the child's
        squared distance is at most the limit and its height is at least the
        floor.
    """
    floats = (x, x_above, y, y_above, z, z_above, limit, floor)
    signature = types.int64(address, *floats, squares)
    return signature, _near_children


def _near_children(context, builder, signature, arguments):
    rows = builder.inttoptr(arguments[0], _VECTOR.as_pointer())
    numbers = [_in_all(builder, number) for number in arguments[1:9]]
    square = None
    for axis in range(3):
        below, above = numbers[2 * axis : 2 * axis + 2]
        short = builder.fsub(_row(builder, rows, axis), above)
        beyond = builder.fsub(below, _row(builder, rows, 3 + axis))
        off = _greater(builder, short, beyond)
        off = _greater(builder, off, ir.Constant(_VECTOR, [0.0] * WIDTH))
        term = builder.fmul(off, off)
        square = term if square is None else builder.fadd(square, term)
    out = builder.inttoptr(arguments[9], _VECTOR.as_pointer())
    builder.store(square, out).align = 4
    limit, floor = numbers[6:]
    # The box of a missing child is NaN, so ordered comparisons with it are
    # false.
    is_near = builder.fcmp_ordered("<=", square, limit)
    is_high = builder.fcmp_ordered(">=", _row(builder, rows, 6), floor)
    bits = builder.bitcast(builder.and_(is_near, is_high), ir.IntType(WIDTH))
    return builder.zext(bits, ir.IntType(64))


def _row(builder, rows, number):
    at = builder.gep(rows, [ir.Constant(ir.IntType(64), number)])
    row = builder.load(at)
    row.align = 4
    return row


def _in_all(builder, number):
    """Broadcasts a number to all elements of a vector."""
    zero = ir.Constant(ir.IntType(32), 0)
    vector = builder.insert_element(_NONE, number, zero)
    return builder.shuffle_vector(vector, _NONE, _FIRST)


def _greater(builder, a, b):
    return builder.select(builder.fcmp_ordered(">", a, b), a, b)
