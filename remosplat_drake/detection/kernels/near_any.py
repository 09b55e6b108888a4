"""Finds points that are near other points."""

import numpy as np

from remosplat_drake.base.kernels import kernel


@kernel
def near_any(p, q, reach):
    """Returns which points are within reach of any other point.

    Args:
        p: Points, shape (n, 3) [m].
        q: The other points, shape (m, 3) [m].
        reach: Reach of each other point, shape (m,), not negative [m].

    Returns:
        True for points within reach, shape (n,) bool.
    """
    found = np.zeros(len(p), np.bool_)
    for i in range(len(p)):
        x, y, z = p[i, 0], p[i, 1], p[i, 2]
        for j in range(len(q)):
            a, b, c = q[j, 0] - x, q[j, 1] - y, q[j, 2] - z
            if a * a + b * b + c * c <= reach[j] * reach[j]:
                found[i] = True
                break
    return found
