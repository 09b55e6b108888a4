"""Finds the one of several convex parts that each triangle belongs to."""

import math

import numpy as np

from remosplat_drake.base.kernels import helper, kernel


@kernel
def owners(triangles, planes, first, slack, small, smallest):
    """Finds the part that each triangle is deepest in.

    A triangle that is in none, but small and nearest to one part with all
    corners, belongs to that; and one that is smaller yet to the nearest.

    Args:
        triangles: Triangles, shape (t, 3, 3) [m].
        planes: Outward normals and offsets of the faces of h parts, normal . x
            + offset being the height above them, shape (k, 4) [m].
        first: Where the planes of each part begin, shape (h + 1,).
        slack: How far triangles may stand out of parts that they are in [m].
        small: Edge below which a triangle may belong to what is nearest [m].
        smallest: Edge below which it does in any case [m].

    Returns:
        The numbers of the parts, shape (t,); -1 where a triangle has to be cut.
    """
    found = np.full(len(triangles), -1)
    out, least = np.empty(3), np.empty(3)
    near = np.empty(3, np.int64)
    for t in range(len(triangles)):
        triangle = triangles[t]
        best = slack
        for part in range(len(first) - 1):
            deepest = -np.inf
            for k in range(first[part], first[part + 1]):
                for c in range(3):
                    deepest = max(deepest, _height(planes[k], triangle[c]))
                if deepest > best:
                    break
            if deepest <= best:
                best, found[t] = deepest, part
        if found[t] >= 0:
            continue
        edge = _longest_edge(triangle)
        if edge >= small:
            continue
        best, nearest = np.inf, -1
        for c in range(3):
            least[c] = np.inf
        for part in range(len(first) - 1):
            for c in range(3):
                out[c] = -np.inf
                for k in range(first[part], first[part + 1]):
                    out[c] = max(out[c], _height(planes[k], triangle[c]))
                if out[c] < least[c]:
                    least[c], near[c] = out[c], part
            if out.max() < best:
                best, nearest = out.max(), part
        if edge < smallest or near[0] == near[1] == near[2]:
            found[t] = nearest
    return found


@helper
def _height(plane, p):
    height = plane[3]
    for c in range(3):
        height += plane[c] * p[c]
    return height


@helper
def _longest_edge(triangle):
    longest = 0.0
    for i in range(3):
        square = 0.0
        for c in range(3):
            step = triangle[i, c] - triangle[i - 1, c]
            square += step * step
        longest = max(longest, square)
    return math.sqrt(longest)
