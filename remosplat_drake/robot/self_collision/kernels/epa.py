"""Depth of the overlap of two convex hulls: the expanding polytope algorithm.

Van den Bergen (2001): a polytope inside the Minkowski difference that contains
the origin is expanded where its surface is nearest to the origin, until this is
impossible. The result is valid even if the iteration stops early: moving the
hulls by the depth along the returned direction separates them, so the negative
depth is a lower bound on the signed distance.
"""

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.returns import REAL, several
from remosplat_drake.base.vectors import cross, dot, norm, set_vector
from remosplat_drake.robot.self_collision.kernels.support import add_support

_STEPS = 60
"""Largest number of vertices added to the first tetrahedron."""

_FACES = 16 * _STEPS
"""Largest number of faces, including removed ones."""

_EXACT = 1e-10
"""Difference of two bounds on a depth that count as equal [m]."""


@kernel(returns=several(REAL, REAL, REAL, REAL))
def penetration(hulls, simplex, size, known, nearest):
    """Computes the signed distance of two hulls that overlap.

    Args:
        hulls: Hulls A and B, as `hull_distance` takes them.
        simplex: Vertices b - a of the Minkowski difference, with a and b; their
            hull contains the origin, shape (3, 4, 3) [m].
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
    for side in range(3):
        for row in range(size):
            set_vector(points[side, row], simplex[side, row])
    n = _make_tetrahedron(hulls, points, size)
    for side in range(2):
        set_vector(nearest[side], points[side + 1, 0])
    if n < 4:  # Both hulls lie in one plane, and only touch.
        for i in range(6):
            nx, ny, nz = _direction_away(points[0], n, i)
            if nx == ny == nz == 0.0:
                continue
            bound = add_support(hulls, nx, ny, nz, points, n)
            if bound > best:
                best, x, y, z = bound, nx, ny, nz
        return best, x, y, z
    inside = np.zeros(3)
    for row in range(4):
        for c in range(3):
            inside[c] += 0.25 * points[0, row, c]
    face = np.zeros((_FACES, 3), np.int64)
    plane = np.zeros((_FACES, 4))
    count = 0
    for i in range(4):
        for c in range(3):
            face[count, c] = (i + c + 1) % 4
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
        if plane[k, 3] >= -bound - _EXACT:
            # Uses the face's normal; other directions may be equally good, but
            # have no face.
            best, x, y, z = bound, nx, ny, nz
            break
        # Faces visible from the new vertex are removed; their rim is joined to
        # it.
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
            face[count, 0], face[count, 1] = edge[i, 0], edge[i, 1]
            face[count, 2] = n
            _set_plane(points[0], face[count], inside, plane[count])
            count += 1
        n += 1
    _set_deepest(points, (face, plane, count), (x, y, z), nearest)
    return best, x, y, z


@helper
def _make_tetrahedron(hulls, points, size):
    """Adds vertices in further directions, until there are four.

    Returns:
        The number of vertices; less than four if all lie in a plane.
    """
    p = points[0, 0]
    while size < 4:
        found = False
        for i in range(6):
            x, y, z = _direction_away(points[0], size, i)
            if x == y == z == 0.0:
                continue
            low = add_support(hulls, x, y, z, points, size)
            if abs(low - dot((x, y, z), p)) > 1e-9:
                found = True
                break
        if not found:
            return size
        size += 1
    return size


@helper
def _direction_away(points, size, i):
    """Makes the i-th of six unit vectors at right angles to some vertices.

    Returns:
        The vector as three numbers, which are 0 if there is no i-th.
    """
    x = 1.0 if i // 2 == 0 else 0.0
    y = 1.0 if i // 2 == 1 else 0.0
    z = 1.0 if i // 2 == 2 else 0.0
    if size > 1:
        e = _edge(points, 0, 1)
        if size == 3:
            x, y, z = _edge(points, 0, 2)
        x, y, z = cross(e, (x, y, z))
    size = norm((x, y, z))
    if size < 1e-12:
        return 0.0, 0.0, 0.0
    share = (1.0 if i % 2 else -1.0) / size
    return share * x, share * y, share * z


@helper
def _edge(points, i, j):
    """The vector from one vertex to another."""
    return (
        points[j, 0] - points[i, 0],
        points[j, 1] - points[i, 1],
        points[j, 2] - points[i, 2],
    )


@helper
def _set_plane(points, face, inside, plane):
    """Sets the outward unit normal of a face, and its distance."""
    x, y, z = cross(
        _edge(points, face[0], face[1]), _edge(points, face[0], face[2])
    )
    size = norm((x, y, z))
    if size < 1e-15:
        plane[0] = plane[1] = plane[2] = 0.0
        plane[3] = np.inf
        return
    x, y, z = x / size, y / size, z / size
    height = dot((x, y, z), points[face[0]])
    if dot((x, y, z), inside) > height:
        x, y, z, height = -x, -y, -z, -height
    plane[0], plane[1], plane[2], plane[3] = x, y, z, height


@helper
def _height(p, plane):
    """Computes the height of a point above a face."""
    return dot(plane, p) - plane[3]


@helper
def _toggle(edge, edges, i, j):
    """Adds an edge to a list, or removes it: two faces share it."""
    for k in range(edges):
        if (edge[k, 0] == i and edge[k, 1] == j) or (
            edge[k, 0] == j and edge[k, 1] == i
        ):
            edge[k, 0], edge[k, 1] = edge[edges - 1, 0], edge[edges - 1, 1]
            return edges - 1
    edge[edges, 0], edge[edges, 1] = i, j
    return edges + 1


@helper
def _set_deepest(points, faces, n, nearest):
    """Sets the points of A and B whose difference is nearest to the origin.

    The point lies on the face nearest to the origin. If hulls overlap equally
    along several directions, the face is normal to n. Of coplanar faces, it is
    the triangle that contains the point.
    """
    face, plane, count = faces
    least, straightest = np.inf, -np.inf
    for i in range(count):
        least = min(least, plane[i, 3])
    for i in range(count):
        if plane[i, 3] <= least + 1e-9:
            straightest = max(straightest, -dot(plane[i], n))
    inmost = -np.inf
    for i in range(count):
        is_least = plane[i, 3] <= least + 1e-9
        if not is_least or -dot(plane[i], n) < straightest - 1e-6:
            continue
        a, b, c = face[i, 0], face[i, 1], face[i, 2]
        s, t = _barycentric(points[0], face[i], plane[i])
        inside = min(s, t, 1.0 - s - t)
        if inside > inmost:
            inmost = inside
            for side in range(2):
                p = points[side + 1]
                for k in range(3):
                    nearest[side, k] = (
                        (1.0 - s - t) * p[a, k] + s * p[b, k] + t * p[c, k]
                    )


@helper
def _barycentric(points, face, plane):
    """Computes two barycentric coordinates of the origin's projection."""
    a = points[face[0]]
    e, f = _edge(points, face[0], face[1]), _edge(points, face[0], face[2])
    d = plane[3]
    g = plane[0] * d - a[0], plane[1] * d - a[1], plane[2] * d - a[2]
    ee, ef, ff, eg, fg = (
        dot(e, e),
        dot(e, f),
        dot(f, f),
        dot(e, g),
        dot(f, g),
    )
    det = ee * ff - ef * ef
    if det <= 0.0:
        return -np.inf, -np.inf
    return (ff * eg - ef * fg) / det, (ee * fg - ef * eg) / det
