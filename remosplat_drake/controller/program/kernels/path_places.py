"""Computes points on a path, for kernels; see `program/path.py`.

A path is represented by its corners q, shape (k, n_q), and their arc lengths s,
shape (k,).
"""

import math

import numpy as np

from remosplat_drake.base.kernels import kernel


@kernel
def place_at(path_q, path_s, s):
    """Computes the configuration at an arc length, shape (n_q,).

    Args:
        path_q: The corners.
        path_s: Arc lengths of the corners.
        s: Arc length; values beyond the ends are clipped.
    """
    if len(path_s) == 1:
        return path_q[0].copy()
    k = 0
    while k < len(path_s) - 2 and path_s[k + 1] <= s:
        k += 1
    share = (s - path_s[k]) / (path_s[k + 1] - path_s[k])
    share = min(max(share, 0.0), 1.0)
    q = path_q[k].copy()
    for c in range(len(q)):
        q[c] += share * (path_q[k + 1, c] - path_q[k, c])
    return q


@kernel
def nearest_place(path_q, path_s, q):
    """Finds the point of a path that is nearest to a configuration.

    Args:
        path_q: The corners.
        path_s: Arc lengths of the corners.
        q: The configuration, shape (n_q,) [rad, m].

    Returns:
        The arc length of the point, and its distance from the configuration. If
        several points are equally near, the point is the one with the largest
        arc length.
    """
    if len(path_s) == 1:
        apart = 0.0
        for c in range(len(q)):
            apart += (path_q[0, c] - q[c]) ** 2
        return 0.0, math.sqrt(apart)
    place, least = 0.0, np.inf
    for k in range(len(path_s) - 1):
        span, along = path_s[k + 1] - path_s[k], 0.0
        for c in range(len(q)):
            step = path_q[k + 1, c] - path_q[k, c]
            along += (q[c] - path_q[k, c]) * step
        share = min(max(along / span**2, 0.0), 1.0)
        apart = 0.0
        for c in range(len(q)):
            step = path_q[k + 1, c] - path_q[k, c]
            apart += (path_q[k, c] + share * step - q[c]) ** 2
        if apart <= least:
            place, least = path_s[k] + share * span, apart
    return place, math.sqrt(least)
