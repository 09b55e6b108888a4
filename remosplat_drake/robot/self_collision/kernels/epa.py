"""How deep two convex hulls overlap: the expanding polytope algorithm.

Van den Bergen (2001): a polytope within the Minkowski difference that holds
the origin grows where its surface is nearest to the origin, until it cannot.
Whenever it stops, what it returns is proved: along the direction that it has
found, the hulls are moved apart by the depth, so that the negative depth is a
lower bound of the signed distance.
"""

import math

import numpy as np
from numba import njit

from remosplat_drake.robot.self_collision.kernels.support import add_support

_STEPS = 60
"""Most vertices that are added to the first tetrahedron."""

_FACES = 16 * _STEPS
"""Most faces that are ever made, those that have vanished counted, too."""

_EXACT = 1e-10
"""Two bounds of a depth that are so close are the same [m]."""


@njit(cache=True)
def penetration(hulls, simplex, size, known, nearest):
    """Computes the signed distance of two hulls that overlap.

    Args:
        hulls: Hulls A and B, as `hull_distance` takes them.
        simplex: Vertices b - a, a, and b of the Minkowski difference, whose
            hull holds the origin, shape (3, 4, 3) [m].
        size: Number of these vertices.
        known: A lower bound of the distance [m], and the unit vector along
            which it holds.
        nearest: Filled with the deepest points of A and of B in A's frame,
            shape (2, 3) [m].

    Returns:
        As `hull_distance`: the distance and its direction.
    """
    best, x, y, z = known
    points = np.zeros((3, 4 + _STEPS, 3))
    points[:, :size] = simplex[:, :size]
    n = _make_tetrahedron(hulls, points, size)
    nearest[0], nearest[1] = points[1, 0], points[2, 0]
    if n < 4:  # Both hulls lie in a plane: across it, they only touch.
        for i in range(6):
            axis, is_known = _direction_away(points[0], n, i)
            if not is_known:
                continue
            bound = add_support(hulls, axis[0], axis[1], axis[2], points, n)
            if bound > best:
                best, x, y, z = bound, axis[0], axis[1], axis[2]
        return best, x, y, z
    inside = np.array([points[0, :4, k].mean() for k in range(3)])
    face = np.zeros((_FACES, 3), np.int64)
    plane = np.zeros((_FACES, 4))
    count = 0
    for i in range(4):
        face[count] = (i + 1) % 4, (i + 2) % 4, (i + 3) % 4
        _set_plane(points[0], face[count], inside, plane[count])
        count += 1
    edge = np.zeros((_FACES, 2), np.int64)
    while n < len(points[0]):
        k = 0
        for i in range(count):
            if plane[i, 3] < plane[k, 3]:
                k = i
        nx, ny, nz = -plane[k, 0], -plane[k, 1], -plane[k, 2]
        bound = add_support(hulls, nx, ny, nz, points, n)
        if bound > best:
            best, x, y, z = bound, nx, ny, nz
        if plane[k, 3] >= -best - _EXACT:
            break
        # The faces that the new vertex sees vanish; their rim joins it.
        edges = 0
        for i in range(count):
            if plane[i, 3] < np.inf and _height(points[0, n], plane[i]) > 1e-14:
                for c in range(3):
                    edges = _toggle(
                        edge, edges, face[i, c], face[i, (c + 1) % 3]
                    )
                plane[i, 3] = np.inf
        if not edges or count + edges > _FACES:
            break
        for i in range(edges):
            face[count] = edge[i, 0], edge[i, 1], n
            _set_plane(points[0], face[count], inside, plane[count])
            count += 1
        n += 1
    _set_deepest(points, face[:count], plane[:count], nearest)
    return best, x, y, z


@njit(cache=True)
def _make_tetrahedron(hulls, points, size):
    """Adds vertices, away from those that are there, until they are four.

    Returns:
        How many there are; less than four if all lie in a plane.
    """
    while size < 4:
        found = False
        for i in range(6):
            n, is_known = _direction_away(points[0], size, i)
            if not is_known:
                continue
            low = add_support(hulls, n[0], n[1], n[2], points, size)
            if abs(low - np.dot(n, points[0, 0])) > 1e-9:
                found = True
                break
        if not found:
            return size
        size += 1
    return size


@njit(cache=True)
def _direction_away(points, size, i):
    """Makes the i-th of six unit vectors at right angles to some vertices.

    Returns:
        The vector, shape (3,), and whether there is an i-th.
    """
    n = np.zeros(3)
    n[i // 2] = 1.0
    if size == 3:
        n = np.cross(points[1] - points[0], points[2] - points[0])
    elif size == 2:
        n = np.cross(points[1] - points[0], n)
    norm = math.sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2])
    if norm < 1e-12:
        return n, False
    return n * ((1.0 if i % 2 else -1.0) / norm), True


@njit(cache=True)
def _set_plane(points, face, inside, plane):
    """Sets the outward unit normal of a face, and its distance."""
    a, b, c = points[face[0]], points[face[1]], points[face[2]]
    e, f = b - a, c - a
    x = e[1] * f[2] - e[2] * f[1]
    y = e[2] * f[0] - e[0] * f[2]
    z = e[0] * f[1] - e[1] * f[0]
    norm = math.sqrt(x * x + y * y + z * z)
    if norm < 1e-15:
        plane[:] = 0.0, 0.0, 0.0, np.inf
        return
    x, y, z = x / norm, y / norm, z / norm
    height = x * a[0] + y * a[1] + z * a[2]
    if x * inside[0] + y * inside[1] + z * inside[2] > height:
        x, y, z, height = -x, -y, -z, -height
    plane[:] = x, y, z, height


@njit(cache=True)
def _height(p, plane):
    """How far a point lies above a face."""
    return plane[0] * p[0] + plane[1] * p[1] + plane[2] * p[2] - plane[3]


@njit(cache=True)
def _toggle(edge, edges, i, j):
    """Adds an edge to a list, or removes it: two faces share it."""
    for k in range(edges):
        if (edge[k, 0] == i and edge[k, 1] == j) or (
            edge[k, 0] == j and edge[k, 1] == i
        ):
            edge[k] = edge[edges - 1]
            return edges - 1
    edge[edges] = i, j
    return edges + 1


@njit(cache=True)
def _set_deepest(points, face, plane, nearest):
    """Sets the points of A and B whose difference is nearest to the origin.

    It lies on a face with the least distance. Of those that share its plane it
    is the one whose triangle holds it.
    """
    least = plane[:, 3].min() + 1e-9
    inmost = -np.inf
    for i in range(len(face)):
        if plane[i, 3] > least:
            continue
        a, b, c = face[i]
        s, t = _barycentric(points[0], face[i], plane[i])
        inside = min(s, t, 1.0 - s - t)
        if inside > inmost:
            inmost = inside
            for side in range(2):
                p = points[side + 1]
                nearest[side] = (1.0 - s - t) * p[a] + s * p[b] + t * p[c]


@njit(cache=True)
def _barycentric(points, face, plane):
    """Computes two barycentric coordinates of the origin's projection."""
    a = points[face[0]]
    e, f = points[face[1]] - a, points[face[2]] - a
    g = plane[:3] * plane[3] - a
    ee, ef, ff = np.dot(e, e), np.dot(e, f), np.dot(f, f)
    eg, fg = np.dot(e, g), np.dot(f, g)
    det = ee * ff - ef * ef
    if det <= 0.0:
        return -np.inf, -np.inf
    return (ff * eg - ef * fg) / det, (ee * fg - ef * eg) / det
