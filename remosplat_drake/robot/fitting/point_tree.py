"""Builds a `PointTree`: points in nested balls."""

import numpy as np

from remosplat_drake.base.kernels.packed import Packed
from remosplat_drake.robot.fitting.kernels.nested_balls import divide
from remosplat_drake.robot.fitting.kernels.points_distance import PointTree

_LEAF = 8
"""A ball with at most this many points is not divided."""


def point_tree(points: np.ndarray) -> Packed[PointTree]:
    """Sorts points into nested balls, each halved along its longest side.

    Args:
        points: At least one point, shape (n, 3) [m].
    """
    depth = max(0, int(np.ceil(np.log2(len(points) / _LEAF))))
    size = 2 ** (depth + 1) - 1
    first, last, right = np.empty((3, size), np.int64)
    center, radius = np.empty((size, 3)), np.empty(size)
    points = np.array(points)
    tree = Packed(PointTree(points, first, last, right, center, radius))
    divide(tree)
    return tree
