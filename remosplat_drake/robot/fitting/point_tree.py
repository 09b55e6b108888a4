"""Builds a `PointTree`: points in nested balls."""

import numpy as np

from remosplat_drake.base.kernels.packed import Packed
from remosplat_drake.robot.fitting.kernels.points_distance import PointTree

_LEAF = 48
"""Largest number of points of a ball that is not divided."""


def point_tree(points: np.ndarray) -> Packed[PointTree]:
    """Sorts points into nested balls, each halved along its longest side.

    Args:
        points: At least one point, shape (n, 3) [m].
    """
    order = np.arange(len(points))
    first, last, right, center, radius = [], [], [], [], []

    def divide(begin: int, end: int) -> int:
        p = points[order[begin:end]]
        lower, upper = p.min(axis=0), p.max(axis=0)
        middle = 0.5 * (lower + upper)
        ball = len(first)
        first.append(begin)
        last.append(end)
        center.append(middle)
        radius.append(np.linalg.norm(p - middle, axis=1).max())
        right.append(-1)
        if len(p) > _LEAF:
            half = len(p) // 2
            along = p[:, (upper - lower).argmax()]
            order[begin:end] = order[begin:end][np.argpartition(along, half)]
            divide(begin, begin + half)
            right[ball] = divide(begin + half, end)
        return ball

    divide(0, len(points))
    return Packed(
        PointTree(
            points[order],
            np.array(first),
            np.array(last),
            np.array(right),
            np.array(center),
            np.array(radius),
        )
    )
