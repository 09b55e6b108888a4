"""Windows: where in a view a splat is nearer than some range (numba).

A window is the least and the largest x and the least and the largest y in the
image plane; it is empty if the least x is above the largest.
"""

import numpy as np

from remosplat_drake.oracle.kernels.footprints import inlined, lean

EMPTY = (2.0, -2.0, 2.0, -2.0)
"""The window of what cannot be seen."""

WHOLE = (-1.0, 1.0, -1.0, 1.0)
"""The window of what may be anywhere in the image."""

# Rounding: a window may be too large, never too small.
_SLACK = 1 + 1e-9


@lean
def disc_window(s, cut, reach, near):
    """Bounds where a disc is seen nearer than a range.

    What is nearer lies in a rectangle of the disc's plane: around the disc, and
    around the circle in which the ball of that range cuts the plane. Of most
    discs near a view nothing is left, or less than a pixel.

    Args:
        s: The whitened disc, see `footprints.whiten`.
        cut: Largest squared Mahalanobis distance that is seen.
        reach: The range [m].
        near: Near plane [m].
    """
    height = s[11]
    reach *= _SLACK
    square = reach * reach - height * height
    if not (reach > 0 and square > 0):
        return EMPTY
    aa = s[0] * s[0] + s[1] * s[1] + s[2] * s[2]
    bb = s[3] * s[3] + s[4] * s[4] + s[5] * s[5]
    # Along the disc's axes, in standard deviations from the camera's foot.
    half = np.sqrt(cut) * _SLACK
    u_most, v_most = np.sqrt(square * aa), np.sqrt(square * bb)
    u_low, u_high = max(s[9] - half, -u_most), min(s[9] + half, u_most)
    v_low, v_high = max(s[10] - half, -v_most), min(s[10] + half, v_most)
    if not (u_low <= u_high and v_low <= v_high):
        return EMPTY
    aa, bb = 1 / aa, 1 / bb
    u, v = max(u_low, -u_high, 0.0), max(v_low, -v_high, 0.0)
    if u * u * aa + v * v * bb > square:
        return EMPTY
    # The circle and the disc along the line through their centres.
    u, v = s[9] * s[9] * aa, s[10] * s[10] * bb
    if u + v > half * np.sqrt(u * aa + v * bb) + np.sqrt(square * (u + v)):
        return EMPTY
    u, u_half = 0.5 * (u_low + u_high) * aa, 0.5 * (u_high - u_low) * aa
    v, v_half = 0.5 * (v_low + v_high) * bb, 0.5 * (v_high - v_low) * bb
    return _window_of_parallelogram(
        (
            height * s[6] + u * s[0] + v * s[3],
            height * s[7] + u * s[1] + v * s[4],
            height * s[8] + u * s[2] + v * s[5],
        ),
        (u_half * s[0], u_half * s[1], u_half * s[2]),
        (v_half * s[3], v_half * s[4], v_half * s[5]),
        near,
    )


@inlined
def _window_of_parallelogram(p, a, b, near):
    """Bounds the image of the parallelogram p +- a +- b."""
    depth = abs(a[2]) + abs(b[2])
    if p[2] + depth < near:
        return EMPTY
    if p[2] - depth < 0.5 * near:
        return WHOLE
    # One over the depths of the corners.
    w0, w1 = 1 / (p[2] - a[2] - b[2]), 1 / (p[2] + a[2] - b[2])
    w2, w3 = 1 / (p[2] - a[2] + b[2]), 1 / (p[2] + a[2] + b[2])
    x0, x1 = (p[0] - a[0] - b[0]) * w0, (p[0] + a[0] - b[0]) * w1
    x2, x3 = (p[0] - a[0] + b[0]) * w2, (p[0] + a[0] + b[0]) * w3
    y0, y1 = (p[1] - a[1] - b[1]) * w0, (p[1] + a[1] - b[1]) * w1
    y2, y3 = (p[1] - a[1] + b[1]) * w2, (p[1] + a[1] + b[1]) * w3
    return (
        min(min(x0, x1), min(x2, x3)),
        max(max(x0, x1), max(x2, x3)),
        min(min(y0, y1), min(y2, y3)),
        max(max(y0, y1), max(y2, y3)),
    )


@inlined
def is_empty(window):
    """Returns whether nothing of a window is in the image."""
    return max(window[0], -1.0) > min(window[1], 1.0) or max(
        window[2], -1.0
    ) > min(window[3], 1.0)
