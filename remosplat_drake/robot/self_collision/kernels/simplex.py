"""The point of a simplex that is nearest to the origin."""

import math

import numpy as np

from remosplat_drake.base.kernels import helper

_FLAT = 1e-13
"""Relative Gram determinant up to which a triangle or tetrahedron counts as
degenerate; it is 1 if the edges are perpendicular."""


@helper
def nearest_on_simplex(simplex, size, weights, v):
    """Finds the point nearest to the origin, and keeps the needed vertices.

    In GJK the newest vertex is always needed, so only the faces that contain it
    are examined.

    Args:
        simplex: Vertices in the first rows of its first array, with their data
            in the others; shape (3, 4, 3) [m]. The newest is the last. Needed
            vertices are moved to the front.
        size: Number of vertices, 1 to 4.
        weights: Filled with the barycentric coordinates of the point.
        v: Filled with the point, shape (3,) [m].

    Returns:
        The number of needed vertices; 4 if the origin lies inside.
    """
    p = simplex[0]
    n = size - 1
    x, y, z = p[n, 0], p[n, 1], p[n, 2]
    least = x * x + y * y + z * z
    ids_1, ids_2 = -1, -1
    s, t = 0.0, 0.0
    v[0], v[1], v[2] = x, y, z
    for i in range(n):
        found, share = _on_segment(p, n, i, v, least)
        if found < least:
            least, ids_1, ids_2, s, t = found, i, -1, share, 0.0
        for j in range(i):
            found, share, other = _on_triangle(p, n, i, j, v, least)
            if found < least:
                least, ids_1, ids_2, s, t = found, i, j, share, other
    if size == 4 and _holds_origin(p, weights):
        v[0] = v[1] = v[2] = 0.0
        return 4
    _keep(simplex, n, ids_1, ids_2)
    weights[0], weights[1], weights[2] = 1.0 - s - t, s, t
    return 1 + (ids_1 >= 0) + (ids_2 >= 0)


@helper
def _on_segment(p, n, i, v, least):
    """Square of the distance to the inside of a segment, and its parameter.

    The square is infinite if the nearest point is an end. v is set if it is
    less than `least`.
    """
    ex, ey, ez = p[i, 0] - p[n, 0], p[i, 1] - p[n, 1], p[i, 2] - p[n, 2]
    length = ex * ex + ey * ey + ez * ez
    along = -(p[n, 0] * ex + p[n, 1] * ey + p[n, 2] * ez)
    if along <= 0.0 or along >= length:
        return np.inf, 0.0
    share = along / length
    x = p[n, 0] + share * ex
    y = p[n, 1] + share * ey
    z = p[n, 2] + share * ez
    found = x * x + y * y + z * z
    if found < least:
        v[0], v[1], v[2] = x, y, z
    return found, share


@helper
def _on_triangle(p, n, i, j, v, least):
    """As `_on_segment`, for the inside of a triangle, with two parameters."""
    ex, ey, ez = p[i, 0] - p[n, 0], p[i, 1] - p[n, 1], p[i, 2] - p[n, 2]
    fx, fy, fz = p[j, 0] - p[n, 0], p[j, 1] - p[n, 1], p[j, 2] - p[n, 2]
    ee = ex * ex + ey * ey + ez * ez
    ef = ex * fx + ey * fy + ez * fz
    ff = fx * fx + fy * fy + fz * fz
    det = ee * ff - ef * ef
    if det <= _FLAT * ee * ff:
        return np.inf, 0.0, 0.0
    re = -(p[n, 0] * ex + p[n, 1] * ey + p[n, 2] * ez)
    rf = -(p[n, 0] * fx + p[n, 1] * fy + p[n, 2] * fz)
    s = (ff * re - ef * rf) / det
    t = (ee * rf - ef * re) / det
    if s <= 0.0 or t <= 0.0 or s + t >= 1.0:
        return np.inf, 0.0, 0.0
    # Computed along the normal, which is exact if the corners are far away.
    cx, cy, cz = ey * fz - ez * fy, ez * fx - ex * fz, ex * fy - ey * fx
    height = p[n, 0] * cx + p[n, 1] * cy + p[n, 2] * cz
    share = height / (cx * cx + cy * cy + cz * cz)
    found = height * share
    if found < least:
        v[0], v[1], v[2] = share * cx, share * cy, share * cz
    return found, s, t


@helper
def _holds_origin(p, weights):
    """Whether a tetrahedron contains the origin; then sets the weights."""
    volume, sizes = 0.0, 1.0
    for i in range(4):
        a, b, c = p[(i + 1) % 4], p[(i + 2) % 4], p[(i + 3) % 4]
        part = (
            a[0] * (b[1] * c[2] - b[2] * c[1])
            + a[1] * (b[2] * c[0] - b[0] * c[2])
            + a[2] * (b[0] * c[1] - b[1] * c[0])
        )
        weights[i] = -part if i % 2 else part
        volume += weights[i]
        if i < 3:
            x, y, z = p[i, 0] - p[3, 0], p[i, 1] - p[3, 1], p[i, 2] - p[3, 2]
            sizes *= math.sqrt(x * x + y * y + z * z)
    if abs(volume) <= 1e-10 * sizes:
        return False
    for i in range(4):
        weights[i] /= volume
        if weights[i] < 0.0:
            return False
    return True


@helper
def _keep(simplex, n, i, j):
    """Moves vertices n, i and j, where these are not -1, to rows 0, 1, 2."""
    _swap(simplex, 0, n)
    i = n if i == 0 else i
    j = n if j == 0 else j
    if i >= 0:
        _swap(simplex, 1, i)
        j = i if j == 1 else j
    if j >= 0:
        _swap(simplex, 2, j)


@helper
def _swap(simplex, i, j):
    """Exchanges two vertices, with their data."""
    for c in range(3):
        for k in range(3):
            kept = simplex[c, i, k]
            simplex[c, i, k] = simplex[c, j, k]
            simplex[c, j, k] = kept
