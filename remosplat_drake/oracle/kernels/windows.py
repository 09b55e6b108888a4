"""Computes windows: parts of a view where a splat is within a range (Numba).

A window consists of the least and the largest x, and the least and the largest
y, in the image plane. It is empty if the least x exceeds the largest. The
functions also take several splats as SIMD lanes (`base/lanes.py`).
"""

from remosplat_drake.base.lanes import greatest, least, magnitude, root, where
from remosplat_drake.oracle.kernels.footprints import inlined

# Margin by which rounding errors may make a window too large, but never too
# small.
_SLACK = 1 + 1e-9


@inlined
def disc_window(s, cut, reach, near):
    """Returns a window that contains the part of a disc within a range.

    The points of the disc's plane within the range form a circle. So this part
    of the disc is in the intersection of two rectangles in the plane: the
    bounds of the disc and the bounds of the circle. For most discs near a view,
    the intersection is empty or smaller than a pixel.

    Args:
        s: The disc, as `footprints.whiten` returns it.
        cut: Squared Mahalanobis distance at which the visible part ends.
        reach: The range [m].
        near: Near plane [m].
    """
    height = s[11]
    reach = reach * _SLACK
    square = reach * reach - height * height
    is_met = (reach > 0) & (square > 0)
    aa = s[0] * s[0] + s[1] * s[1] + s[2] * s[2]
    bb = s[3] * s[3] + s[4] * s[4] + s[5] * s[5]
    # These coordinates are along the disc's axes, in standard deviations. Their
    # origin is the foot of the perpendicular from the camera to the plane.
    half = root(cut) * _SLACK
    u_most, v_most = root(square * aa), root(square * bb)
    u_low, u_high = greatest(s[9] - half, -u_most), least(s[9] + half, u_most)
    v_low, v_high = greatest(s[10] - half, -v_most), least(s[10] + half, v_most)
    is_met = is_met & (u_low <= u_high) & (v_low <= v_high)
    aa, bb = 1 / aa, 1 / bb
    u = greatest(greatest(u_low, -u_high), 0.0)
    v = greatest(greatest(v_low, -v_high), 0.0)
    is_met = is_met & (u * u * aa + v * v * bb <= square)
    # The circle and the disc must also overlap along the line through their
    # centres.
    u, v = s[9] * s[9] * aa, s[10] * s[10] * bb
    most = half * root(u * aa + v * bb) + root(square * (u + v))
    is_met = is_met & (u + v <= most)
    u, u_half = 0.5 * (u_low + u_high) * aa, 0.5 * (u_high - u_low) * aa
    v, v_half = 0.5 * (v_low + v_high) * bb, 0.5 * (v_high - v_low) * bb
    window = _window_of_parallelogram(
        (
            height * s[6] + u * s[0] + v * s[3],
            height * s[7] + u * s[1] + v * s[4],
            height * s[8] + u * s[2] + v * s[5],
        ),
        (u_half * s[0], u_half * s[1], u_half * s[2]),
        (v_half * s[3], v_half * s[4], v_half * s[5]),
        near,
    )
    x_low = where(is_met, window[0], 2.0)
    return x_low, where(is_met, window[1], -2.0), window[2], window[3]


@inlined
def _window_of_parallelogram(p, a, b, near):
    """Returns a window around the image of the parallelogram p +- a +- b."""
    depth = magnitude(a[2]) + magnitude(b[2])
    # These are the reciprocals of the corners' depths.
    w0, w1 = 1 / (p[2] - a[2] - b[2]), 1 / (p[2] + a[2] - b[2])
    w2, w3 = 1 / (p[2] - a[2] + b[2]), 1 / (p[2] + a[2] + b[2])
    x0, x1 = (p[0] - a[0] - b[0]) * w0, (p[0] + a[0] - b[0]) * w1
    x2, x3 = (p[0] - a[0] + b[0]) * w2, (p[0] + a[0] + b[0]) * w3
    y0, y1 = (p[1] - a[1] - b[1]) * w0, (p[1] + a[1] - b[1]) * w1
    y2, y3 = (p[1] - a[1] + b[1]) * w2, (p[1] + a[1] + b[1]) * w3
    # If a corner may be beside or behind the camera, the window is unbounded.
    is_ahead = p[2] - depth >= 0.5 * near
    is_behind = p[2] + depth < near
    x_low = least(least(x0, x1), least(x2, x3))
    x_high = greatest(greatest(x0, x1), greatest(x2, x3))
    y_low = least(least(y0, y1), least(y2, y3))
    y_high = greatest(greatest(y0, y1), greatest(y2, y3))
    return (
        where(is_behind, 2.0, where(is_ahead, x_low, -1.0)),
        where(is_behind, -2.0, where(is_ahead, x_high, 1.0)),
        where(is_ahead, y_low, -1.0),
        where(is_ahead, y_high, 1.0),
    )
