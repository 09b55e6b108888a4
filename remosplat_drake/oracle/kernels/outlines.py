"""Outlines of projected splats: bounds of their fragments in a view (Numba).

An outline is a quadratic form of the ray (x, y, 1), <= 0 inside, with entries
xx, xy, xz, yy, yz, zz; its rows and columns bound the pixels that must be
tested. Splats and rows may be SIMD lanes.
"""

from remosplat_drake.base.lanes import greatest, magnitude, root, where
from remosplat_drake.oracle.kernels.footprints import inlined


@inlined
def outline(s, rules, cut):
    """Returns the outline of a projected splat: where its weight is `cut`."""
    if rules.is_surfel:
        return (
            s[0] * s[0] + s[3] * s[3] - cut * (s[6] * s[6]),
            s[0] * s[1] + s[3] * s[4] - cut * (s[6] * s[7]),
            s[0] * s[2] + s[3] * s[5] - cut * (s[6] * s[8]),
            s[1] * s[1] + s[4] * s[4] - cut * (s[7] * s[7]),
            s[1] * s[2] + s[4] * s[5] - cut * (s[7] * s[8]),
            s[2] * s[2] + s[5] * s[5] - cut * (s[8] * s[8]),
        )
    # A line is as far from the origin as |center x ray| / |ray|. With inner
    # products, rounding would dominate for thin ellipsoids.
    n = (
        s[10] * s[6] - s[11] * s[3],
        s[10] * s[7] - s[11] * s[4],
        s[10] * s[8] - s[11] * s[5],
        s[11] * s[0] - s[9] * s[6],
        s[11] * s[1] - s[9] * s[7],
        s[11] * s[2] - s[9] * s[8],
        s[9] * s[3] - s[10] * s[0],
        s[9] * s[4] - s[10] * s[1],
        s[9] * s[5] - s[10] * s[2],
    )
    return (
        _product(n, 0, 0) - cut * _product(s, 0, 0),
        _product(n, 0, 1) - cut * _product(s, 0, 1),
        _product(n, 0, 2) - cut * _product(s, 0, 2),
        _product(n, 1, 1) - cut * _product(s, 1, 1),
        _product(n, 1, 2) - cut * _product(s, 1, 2),
        _product(n, 2, 2) - cut * _product(s, 2, 2),
    )


@inlined
def _product(s, i, j):
    """Returns the inner product of the images of ray coordinates i and j."""
    return s[i] * s[j] + s[3 + i] * s[3 + j] + s[6 + i] * s[6 + j]


@inlined
def near_outline(s, reach):
    """Returns the region in which a disc's plane is nearer than `reach`.

    The range of the plane along a ray is height |ray| / C, with the height and
    the form C of `footprints`.
    """
    square, height = reach * reach, s[9] * s[9]
    return (
        height - square * (s[6] * s[6]),
        -square * (s[6] * s[7]),
        -square * (s[6] * s[8]),
        height - square * (s[7] * s[7]),
        -square * (s[7] * s[8]),
        height - square * (s[8] * s[8]),
    )


@inlined
def row_span(s, rules, conic):
    """Returns the first and last image row y that an outline meets."""
    xx, xy, xz, yy, yz, zz = conic
    # Rows whose columns have a discriminant >= 0.
    a, b, c = xx * yy - xy * xy, xx * yz - xy * xz, xx * zz - xz * xz
    if not rules.is_surfel:
        low, high = _quadratic_span(a, b, c, 0.0)
        return where(xx > 0, low, -1.0), where(xx > 0, high, 1.0)
    # A branch of a hyperbola that opens along x is convex, and widest where it
    # leaves the image.
    x = where(s[9] * s[6] > 0, 1.0, -1.0)
    is_closed = xx > 0
    return _quadratic_span(
        where(is_closed, a, yy),
        where(is_closed, b, xy * x + yz),
        where(is_closed, c, xx + 2 * xz * x + zz),
        s[9] * where(is_closed, s[7] * xx - s[6] * xy, s[7]),
    )


@inlined
def column_span(s, rules, conic, y):
    """Returns the columns x of row y inside an outline; empty if low > high."""
    xx, xy, xz, yy, yz, zz = conic
    return _quadratic_span(
        xx,
        xy * y + xz,
        (yy * y + 2 * yz) * y + zz,
        s[9] * s[6] if rules.is_surfel else 0.0 * s[6],
    )


@inlined
def _quadratic_span(tt, t, one, side):
    """Returns an interval that contains all x with tt x^2 + 2 t x + one <= 0.

    If tt < 0, the solutions are two half-lines: one before and one behind the
    camera. `side` > 0 selects the upper one, < 0 the lower one; 0, and forms
    that are linear up to rounding, give the whole image.
    """
    square = t * t - tt * one
    half = root(greatest(square, 0.0))
    inverse = 1 / tt
    low, high = (-t - half) * inverse, (-t + half) * inverse
    is_inner, is_real = tt > 0, square >= 0
    is_upper, is_lower = side > 0, side < 0
    has_low = is_real & (is_inner | is_upper)
    has_high = is_real & (is_inner | is_lower)
    low, high = where(has_low, low, -1.0), where(has_high, high, 1.0)
    # A form that is positive everywhere has no inside.
    is_empty = is_inner & (square < 0)
    low, high = where(is_empty, 2.0, low), where(is_empty, -2.0, high)
    is_linear = magnitude(tt) <= 1e-9 * (magnitude(t) + magnitude(one))
    return where(is_linear, -1.0, low), where(is_linear, 1.0, high)
