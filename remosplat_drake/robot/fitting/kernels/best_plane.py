"""Compares planes that cut a surface in two by the hulls of the halves."""

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
def best_plane(vertices, edges, planes, p, off, least):
    """Finds the plane that frees points most from a hull, by cutting it in two.

    The gain of a point is its distance from the nearer of the two halves' hulls
    minus its distance from the whole hull, and at most its distance from the
    surface. A plane is compared by the sum of these gains, each times the
    point's distance from the surface.

    Args:
        vertices: Vertices of a surface, shape (v, 3) [m].
        edges: Indices of the two vertices of each edge, shape (e, 2).
        planes: Unit normals and offsets of planes, normal . x = offset, shape
            (k, 4) [m].
        p: Points, shape (n, 3) [m].
        off: Their distances from the surface, shape (n,) [m]; larger than
            `least`.
        least: Planes that increase no point's distance by more than this are
            ignored [m].

    Returns:
        The index of the plane, the first of equal ones; -1 if there is none.
    """
    height = np.empty(len(vertices))
    sides = np.empty((2, len(vertices) + len(edges), 3))
    work = np.zeros((3, 4, 3)), np.zeros(4), np.zeros(3)
    before, every = np.empty(len(p)), 0.0
    for i in range(len(p)):
        before[i] = _distance(vertices, p[i], np.inf, work)
        every += off[i] * off[i]
    best, index = 0.0, -1
    for k in range(len(planes)):
        if best >= every:
            break
        count = _divide(vertices, edges, planes[k], height, sides)
        if count[0] == 0 or count[1] == 0:
            continue
        total, most, left = 0.0, 0.0, every
        for i in range(len(p)):
            # A plane that cannot be the best one is not compared any further.
            if total + left <= best:
                break
            enough = nearest = before[i] + off[i]
            for side in range(2):
                if nearest > before[i]:
                    half = sides[side, : count[side]]
                    found = _distance(half, p[i], nearest, work)
                    nearest = min(nearest, found)
            free = off[i]
            if nearest < enough:
                free = max(nearest - before[i], 0.0)
            most, total = max(most, free), total + free * off[i]
            left -= off[i] * off[i]
        if most > least and total > best:
            best, index = total, k
    return index


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
