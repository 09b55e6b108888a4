"""Computes the distance of points from the hulls of a surface cut in two."""

import math

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.robot.self_collision.kernels.simplex import (
    nearest_on_simplex,
)

_STEPS = 40
"""Number of GJK iterations after which the result is only a lower bound."""

_EXACT = 1e-6
"""Difference of two bounds on a distance that count as equal [m]."""


@kernel
def freed_points(vertices, edges, planes, p):
    """Computes the gain in distance of points from a hull that is cut in two.

    Args:
        vertices: Vertices of a surface, shape (v, 3) [m].
        edges: Indices of the two vertices of each edge, shape (e, 2).
        planes: Unit normals and offsets of planes, normal . x = offset, shape
            (k, 4) [m].
        p: Points, shape (n, 3) [m].

    Returns:
        The distance from the nearer of the two halves' hulls minus the distance
        from the whole hull, shape (k, n) [m]; zero if all of the surface is on
        one side of the plane.
    """
    free = np.zeros((len(planes), len(p)))
    height = np.empty(len(vertices))
    sides = np.empty((2, len(vertices) + len(edges), 3))
    work = np.zeros((3, 4, 3)), np.zeros(4), np.zeros(3)
    before = np.empty(len(p))
    for i in range(len(p)):
        before[i] = _distance(vertices, p[i], np.inf, work)
    for k in range(len(planes)):
        count = _divide(vertices, edges, planes[k], height, sides)
        if count[0] == 0 or count[1] == 0:
            continue
        for i in range(len(p)):
            least = np.inf
            for side in range(2):
                if least > before[i]:
                    half = sides[side, : count[side]]
                    least = min(least, _distance(half, p[i], least, work))
            free[k, i] = max(least - before[i], 0.0)
    return free


@helper
def _divide(vertices, edges, plane, height, sides):
    """Assigns vertices to the sides of a plane, and edge crossings to both."""
    below = above = 0
    for i in range(len(vertices)):
        height[i] = -plane[3]
        for c in range(3):
            height[i] += plane[c] * vertices[i, c]
        if height[i] < 0.0:
            sides[0, below] = vertices[i]
            below += 1
        elif height[i] > 0.0:
            sides[1, above] = vertices[i]
            above += 1
    if below == 0 or above == 0:
        return below, above
    for i in range(len(vertices)):
        if height[i] == 0.0:
            sides[0, below] = sides[1, above] = vertices[i]
            below, above = below + 1, above + 1
    for e in range(len(edges)):
        a, b = edges[e]
        if height[a] * height[b] < 0.0:
            share = height[a] / (height[a] - height[b])
            for c in range(3):
                x = vertices[a, c] + share * (vertices[b, c] - vertices[a, c])
                sides[0, below, c] = sides[1, above, c] = x
            below, above = below + 1, above + 1
    return below, above


@helper
def _distance(points, p, enough, work):
    """Computes with GJK the distance of a point from the hull of points [m].

    It is zero within the hull.

    Args:
        points: Points, shape (n, 3) [m].
        p: The point, shape (3,) [m].
        enough: If the distance proves to be at least this, a lower bound is
            returned [m].
        work: Arrays of shape (3, 4, 3), (4,) and (3,).
    """
    simplex, weights, v = work
    for c in range(3):
        v[c] = points[0, c] - p[c]
    size, best = 0, 0.0
    for _ in range(_STEPS):
        norm = math.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
        if norm < _EXACT:
            return 0.0
        lowest, row = np.inf, 0
        for i in range(len(points)):
            along = v[0] * points[i, 0] + v[1] * points[i, 1]
            along += v[2] * points[i, 2]
            if along < lowest:
                lowest, row = along, i
        bound = lowest - v[0] * p[0] - v[1] * p[1] - v[2] * p[2]
        best = max(best, bound / norm)
        if norm - best < _EXACT or best >= enough:
            return best
        for c in range(3):
            simplex[0, size, c] = points[row, c] - p[c]
        size = nearest_on_simplex(simplex, size + 1, weights, v)
        if size == 4:
            return 0.0
    return best
