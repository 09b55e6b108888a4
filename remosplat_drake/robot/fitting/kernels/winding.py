"""Winding numbers of surfaces around points."""

import math

from remosplat_drake.base.kernels import helper, kernel


@kernel
def is_inside(p, surface):
    """Returns whether a surface winds around a point.

    The solid angles of its triangles are added up (van Oosterom and Strackee,
    The solid angle of a plane triangle, 1983).

    Args:
        p: The point, shape (3,) [m].
        surface: Triangles, shape (t, 3, 3) [m]; small gaps have little effect.
    """
    total = 0.0
    for i in range(len(surface)):
        a, b, c = (
            _from(surface[i, 0], p),
            _from(surface[i, 1], p),
            _from(surface[i, 2], p),
        )
        x, y, z = math.sqrt(_dot(a, a)), math.sqrt(_dot(b, b)), 0.0
        z = math.sqrt(_dot(c, c))
        volume = (
            a[0] * (b[1] * c[2] - b[2] * c[1])
            + a[1] * (b[2] * c[0] - b[0] * c[2])
            + a[2] * (b[0] * c[1] - b[1] * c[0])
        )
        rest = x * y * z + _dot(a, b) * z + _dot(b, c) * x + _dot(c, a) * y
        total += 2.0 * math.atan2(volume, rest)
    return abs(total) > 2.0 * math.pi


@helper
def _from(q, p):
    return q[0] - p[0], q[1] - p[1], q[2] - p[2]


@helper
def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
