"""Computes speeds along a path, for kernels; see `program/path.py`.

A path has a greatest speed v at each of its corners, shape (k,). Between two
corners, dv/dt is constant, so v^2 is linear in the arc length s.
"""

import math

from remosplat_drake.base.kernels import kernel
from remosplat_drake.base.kernels.returns import REAL


@kernel(returns=REAL)
def change_at(path_s, path_v, path_a, s, speed):
    """Computes the greatest dv/dt of a robot at a point of a path [1/s^2].

    Args:
        path_s: Arc lengths of the corners, shape (k,).
        path_v: Greatest speeds at the corners, shape (k,) [1/s].
        path_a: Greatest dv/dt at the corners for a robot at rest and for a
            robot at the greatest speed, shape (k, 2) [1/s^2].
        s: Arc length of the point.
        speed: Speed of the robot along the path [1/s].
    """
    k = 0
    while k < len(path_s) - 1 and path_s[k + 1] <= s:
        k += 1
    share = min((speed / max(path_v[k], 1e-9)) ** 2, 1.0)
    return path_a[k, 0] + share * (path_a[k, 1] - path_a[k, 0])


@kernel(returns=REAL)
def way_ahead(path_s, path_v, s, time):
    """Computes the arc length that the greatest speeds cover in a time.

    Args:
        path_s: Arc lengths of the corners, shape (k,).
        path_v: Greatest speeds at the corners, shape (k,) [1/s].
        s: Arc length to start from.
        time: The time [s].

    Returns:
        The covered arc length, which is at most that to the path's end.
    """
    k, last, start = 0, len(path_s) - 1, s
    while k < last and path_s[k + 1] <= s:
        k += 1
    while k < last and time > 0.0:
        span = path_s[k + 1] - path_s[k]
        share = (s - path_s[k]) / span
        before, after = path_v[k] ** 2, path_v[k + 1] ** 2
        v = math.sqrt(before + share * (after - before))
        mean = 0.5 * (v + path_v[k + 1])
        left = path_s[k + 1] - s
        if mean * time < left:
            change = 0.5 * (after - before) / span
            return max(s - start + (v + 0.5 * change * time) * time, 0.0)
        time -= left / mean
        s, k = path_s[k + 1], k + 1
    return s - start
