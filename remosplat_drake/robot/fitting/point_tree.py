"""Builds a `PointTree`: points in nested balls."""

import numpy as np

from remosplat_drake.base.kernels.packed import Packed
from remosplat_drake.robot.fitting.kernels.points_distance import PointTree

_LEAF = 8
"""Largest number of points of a ball that is not divided."""


def point_tree(points: np.ndarray) -> Packed[PointTree]:
    """Sorts points into nested balls, each halved along its longest side.

    All balls of one level are divided together.

    Args:
        points: At least one point, shape (n, 3) [m].
    """
    n = len(points)
    depth = max(0, int(np.ceil(np.log2(n / _LEAF))))
    size = 2 ** (depth + 1) - 1
    first, last = np.empty((2, size), np.int64)
    right, radius = np.full(size, -1), np.empty(size)
    center = np.empty((size, 3))
    start, balls = np.array([0, n]), np.zeros(1, np.int64)
    for level in range(depth + 1):
        lower = np.minimum.reduceat(points, start[:-1])
        upper = np.maximum.reduceat(points, start[:-1])
        of_point = np.repeat(np.arange(len(balls)), np.diff(start))
        middle = 0.5 * (lower + upper)
        away = np.linalg.norm(points - middle[of_point], axis=1)
        first[balls], last[balls] = start[:-1], start[1:]
        center[balls] = middle
        radius[balls] = np.maximum.reduceat(away, start[:-1])
        if level < depth:
            longest = (upper - lower).argmax(axis=1)
            along = points[np.arange(n), longest[of_point]]
            points = points[np.lexsort((along, of_point))]
            halves = (start[:-1] + start[1:]) // 2
            start = np.sort(np.append(start, halves))
            # The first child and all balls in it precede the second.
            right[balls] = balls + 2 ** (depth - level)
            balls = np.stack([balls + 1, right[balls]], axis=1).ravel()
    return Packed(PointTree(points, first, last, right, center, radius))
