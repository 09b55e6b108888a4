"""Computes outlines of projected splats, which bound their fragments (Numba).

An outline is a quadratic form of the ray (x, y, 1) with the coefficients xx,
xy, xz, yy, yz and zz. The form is <= 0 inside the outline. The rows and columns
that the outline meets bound the pixels that must be tested. The functions also
take several splats or rows as SIMD lanes.
"""

from remosplat_drake.base.lanes import greatest, magnitude, root, where
from remosplat_drake.oracle.kernels.footprints import inlined


@inlined
def outline(s, rules, cut):
    """Returns the outline on which a projected splat has the weight `cut`."""
    if rules.is_surfel:
        return (
            s[0] * s[0] + s[3] * s[3] - cut * (s[6] * s[6]),
            s[0] * s[1] + s[3] * s[4] - cut * (s[6] * s[7]),
            s[0] * s[2] + s[3] * s[5] - cut * (s[6] * s[8]),
            s[1] * s[1] + s[4] * s[4] - cut * (s[7] * s[7]),
            s[1] * s[2] + s[4] * s[5] - cut * (s[7] * s[8]),
            s[2] * s[2] + s[5] * s[5] - cut * (s[8] * s[8]),
        )
    # The distance of a line from the origin is computed as |center x ray| /
    # |ray|. If it were computed from inner products, rounding errors would
    # dominate for thin ellipsoids.
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
    """Returns the inner product of columns i and j of the splat's matrix."""
    return s[i] * s[j] + s[3 + i] * s[3 + j] + s[6 + i] * s[6 + j]


@inlined
def near_outline(s, reach):
    """Returns the outline of the region where a disc's plane is within `reach`.

    The range of the plane along a ray is height |ray| / C. The module
    `footprints` defines the height and the form C.
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
    # These are the rows in which the quadratic form has a discriminant >= 0.
    a, b, c = xx * yy - xy * xy, xx * yz - xy * xz, xx * zz - xz * xz
    if not rules.is_surfel:
        low, high = _quadratic_span(a, b, c, 0.0)
        return where(xx > 0, low, -1.0), where(xx > 0, high, 1.0)
    # A branch of a hyperbola that opens along x is convex. Its width is largest
    # at the edge of the image.
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
    """Returns the interval of x inside an outline in row y; may be empty."""
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

    If tt < 0, the solutions are two half-lines: one in front of the camera and
    one behind it. `side` > 0 selects the upper half-line, `side` < 0 the lower.
    The interval is the whole image if `side` is 0, or if the form is linear up
    to rounding.
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
    # If the form is positive everywhere, the interval is empty.
    is_empty = is_inner & (square < 0)
    low, high = where(is_empty, 2.0, low), where(is_empty, -2.0, high)
    is_linear = magnitude(tt) <= 1e-9 * (magnitude(t) + magnitude(one))
    return where(is_linear, -1.0, low), where(is_linear, 1.0, high)
