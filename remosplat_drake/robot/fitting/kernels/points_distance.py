"""The least distance between two sets of points, each in a tree of balls."""

import math
from typing import NamedTuple

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.robot.self_collision.kernels.turning import point_to_world

_DEPTH = 128
"""Largest number of queued pairs of balls, many more than trees require."""


class PointTree(NamedTuple):
    """The n points of a surface in k nested balls; parents precede children.

    Attributes:
        points: The points, shape (n, 3) [m]; those of each ball are
            consecutive.
        first: Index of each ball's first point, shape (k,).
        last: Index after each ball's last point, shape (k,).
        right: Index of each ball's second child, shape (k,); the first child is
            the next ball. -1 without children.
        center: Centres, shape (k, 3) [m].
        radius: Radii, shape (k,) [m].
    """

    points: np.ndarray
    first: np.ndarray
    last: np.ndarray
    right: np.ndarray
    center: np.ndarray
    radius: np.ndarray


@kernel
def points_distances(a, b, X_AB, enough, within):
    """Computes the least distances between two sets of points in m poses.

    Args:
        a: The first set of points, a packed `PointTree` in frame A.
        b: The second set, in frame B.
        X_AB: Poses, shape (m, 4, 4).
        enough: Distances up to which the result need not be the least, shape
            (m,) [m].
        within: Distances at or beyond which the result is infinite, shape (m,)
            [m].

    Returns:
        The distances, infinite from `within` on, shape (m,) [m], and the index
        of the nearest point of each set, shape (m,) each; -1 if the distance is
        infinite.
    """
    m = len(X_AB)
    distance = np.full(m, np.inf)
    nearest_a, nearest_b = np.full(m, -1), np.full(m, -1)
    todo = np.empty((_DEPTH, 2), np.int64)
    bound = np.empty(_DEPTH)
    p_AQ = np.empty(3)
    for row in range(m):
        X, best = X_AB[row], within[row]
        count, todo[0, 0], todo[0, 1] = 1, 0, 0
        bound[0] = _apart(a, b, X, 0, 0)
        while count and best > enough[row]:
            count -= 1
            i, j = todo[count]
            if bound[count] >= best:
                continue
            if a.right[i] < 0 and b.right[j] < 0:
                square = best * best
                for q in range(b.first[j], b.last[j]):
                    point_to_world(X, b.points[q], p_AQ)
                    for k in range(a.first[i], a.last[i]):
                        x = a.points[k, 0] - p_AQ[0]
                        y = a.points[k, 1] - p_AQ[1]
                        z = a.points[k, 2] - p_AQ[2]
                        found = x * x + y * y + z * z
                        if found < square:
                            square = found
                            best = distance[row] = math.sqrt(found)
                            nearest_a[row], nearest_b[row] = k, q
                continue
            splits_a = b.right[j] < 0 or (
                a.right[i] >= 0 and a.radius[i] >= b.radius[j]
            )
            for side in range(2):
                s, t = i, j
                if splits_a:
                    s = a.right[i] if side else i + 1
                else:
                    t = b.right[j] if side else j + 1
                todo[count + side, 0], todo[count + side, 1] = s, t
                bound[count + side] = _apart(a, b, X, s, t)
            # The nearer pair is visited first.
            if bound[count] < bound[count + 1]:
                bound[count], bound[count + 1] = bound[count + 1], bound[count]
                for c in range(2):
                    other = todo[count, c]
                    todo[count, c] = todo[count + 1, c]
                    todo[count + 1, c] = other
            count += 2
    return distance, nearest_a, nearest_b


@helper
def _apart(a, b, X, i, j):
    """Returns the least distance between points of two balls [m]."""
    square = 0.0
    for r in range(3):
        p = X[r, 3] - a.center[i, r]
        for c in range(3):
            p += X[r, c] * b.center[j, c]
        square += p * p
    return math.sqrt(square) - a.radius[i] - b.radius[j]
