"""Computes bounds of distances between two samples of a motion.

A gap is a distance that depends on one moving point, and that changes by at
most the motion of this point. An example is the distance from a sphere's centre
to the scene. Another is the distance between two spheres, for which the point
is the vector between their centres. The level of a gap is the distance that it
must keep. Its margin is the distance minus the level.

Let r_0 and r_1 be the margins at two samples, and s the length of the point's
path between the samples. Between the samples, the margin is at least (r_0 + r_1
- s) / 2.

There is an upper bound of s. Let a be a bound of the point's acceleration, and
t the time between the samples. At the time x after the first sample, the
velocity differs from its mean by at most a (x^2 + (t - x)^2) / (2 t). So s
exceeds the straight distance between the two positions by at most a t^2 / 3.
"""

import math

import numpy as np

from remosplat_drake.base.kernels import helper, kernel

TOLERANCE = 5e-4
"""Amount by which a distance may fall below the required one between two
samples of a path [m].

Without this tolerance, no motion of a sphere along an obstacle, at the stopping
distance, could be verified.
"""

_ROUNDING = 1e-9
"""Bound of rounding errors of distances [m]."""


@helper
def tolerated(level, stopping) -> float:
    """Computes the amount by which a distance may fall below its level [m].

    A late tick ends between two samples, and the distance at its end is the
    level of the next tick. Distances must not decrease a little in each of many
    such ticks. So for a level between d_s - `TOLERANCE` and d_s, where d_s is
    the stopping distance, no distance below d_s - `TOLERANCE` is tolerated.

    Args:
        level: The level: the distance to keep, or the present distance if that
            is smaller [m].
        stopping: The stopping distance [m].
    """
    spare = level - (stopping - TOLERANCE)
    if spare < -_ROUNDING:
        return TOLERANCE
    return min(max(spare, 0.0), TOLERANCE)


@helper
def apart(p, q) -> float:
    """Computes the distance between two points [m].

    Args:
        p: One point, shape (3,) [m].
        q: The other point, shape (3,) [m].
    """
    x, y, z = q[0] - p[0], q[1] - p[1], q[2] - p[2]
    return math.sqrt(x * x + y * y + z * z)


@helper
def bend_of(bound, speed) -> float:
    """Returns a bound of a sphere's acceleration while u is held [m/s^2].

    Args:
        bound: The part of `RobotModel.hessian_bound` for the sphere, shape
            (n_u, n_u).
        speed: Absolute values |u| of the command, shape (n_u,).
    """
    total = 0.0
    for a in range(len(speed)):
        for b in range(len(speed)):
            total += bound[a, b] * speed[a] * speed[b]
    return total


@helper
def longest_way(p, q, bend, time) -> float:
    """Returns a bound of the length of a point's path between positions [m].

    Args:
        p: The first position, shape (3,) [m].
        q: The second position, shape (3,) [m].
        bend: Bound of the point's acceleration [m/s^2].
        time: Time between the two positions [s].
    """
    return apart(p, q) + detour(bend, time)


@helper
def detour(bend, time) -> float:
    """Returns a bound of the difference of a path and its chord [m].

    Args:
        bend: Bound of the point's acceleration [m/s^2].
        time: Time from the path's start to its end [s].
    """
    return bend * time * time / 3.0


@kernel(linked=True)
def longest_ways(point, span, bend):
    """Returns bounds of the paths of n points between k + 1 samples.

    Args:
        point: Position of each point at each sample, shape (k + 1, n, 3) [m].
        span: Time between two samples, shape (k, n) [s].
        bend: Bounds of the points' accelerations, shape (n,) [m/s^2].

    Returns:
        Bounds of the lengths of the paths from each sample to the next, shape
        (k, n) [m].
    """
    k, n = span.shape
    way = np.empty((k, n))
    for j in range(k):
        for i in range(n):
            way[j, i] = longest_way(
                point[j, i], point[j + 1, i], bend[i], span[j, i]
            )
    return way


@kernel(linked=True)
def margin_bounds(point, start, margin, way, tolerance):
    """Returns lower bounds of margins, and the required margins.

    The margin of a point is its distance minus the distance that it must keep.
    If the point has moved by x from its start, its margin has decreased by at
    most x.

    Args:
        point: Position of each of n points at each of k samples, shape (k, n,
            3) [m].
        start: Position at which the margin of each point is known, shape (n, 3)
            [m].
        margin: The margins at `start`, shape (n,) [m].
        way: Bounds of the lengths of the paths before each sample, and after
            the last sample if the path continues, shape (k or k + 1, n) [m].
        tolerance: Amount by which each margin may fall below zero between two
            samples, shape (n,) [m].

    Returns:
        Lower bounds of the margins, and the required margins, which prove that
        the parts of the paths next to each sample are clear. Both have the
        shape (k, n) [m].
    """
    k, n = point.shape[:2]
    known = np.empty((k, n))
    wanted = np.empty((k, n))
    for j in range(k):
        after = min(j + 1, len(way) - 1)
        for i in range(n):
            known[j, i] = margin[i] - apart(start[i], point[j, i])
            half = 0.5 * max(way[j, i], way[after, i])
            wanted[j, i] = max(half - tolerance[i], 0.0)
    return known, wanted
