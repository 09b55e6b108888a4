"""Bounds on distances between two looks at them.

A gap is a distance that hangs on one point which moves with the robot, and
changes by no more than that point moves: from a sphere's centre to the scene,
or between two spheres, where the point is the vector between their centres.
Its room is what it has above the level that it must keep.

Between two looks, with rooms r_0 and r_1 and a point that has travelled s in
all, the room falls to no less than (r_0 + r_1 - s) / 2.

The way s is bounded, not known. Let a bound how fast the point's velocity v
changes, and t be the time between the looks. At the time x after the first, v
differs from its mean by at most a (x^2 + (t - x)^2) / (2 t), so the way is at
most a t^2 / 3 longer than the straight line between the two places.
"""

import math

import numpy as np

from remosplat_drake.base.kernels import helper, kernel

TOLERANCE = 5e-4
"""How far distances may fall below their level between two looks [m].

Without it a sphere that glides along an obstacle at its stopping distance
could never be shown to keep it.
"""

_ROUNDING = 1e-9
"""Rounding errors of distances [m]."""


@helper
def tolerated(level, stopping) -> float:
    """Computes how far below its level a distance may fall [m].

    A late tick ends between two looks, and the next one takes the distance
    there for its level. So that distances cannot creep down, one that is a
    little below the stopping distance falls no lower than one that keeps it.

    Args:
        level: The level: the distance to keep, or the present one if that is
            less [m].
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
    """Bounds how fast a sphere's velocity changes while u is held [m/s^2].

    Args:
        bound: The sphere's part of `RobotModel.hessian_bound`, shape (n_u,
            n_u).
        speed: Absolute values |u| of the command, shape (n_u,).
    """
    total = 0.0
    for a in range(len(speed)):
        for b in range(len(speed)):
            total += bound[a, b] * speed[a] * speed[b]
    return total


@helper
def longest_way(p, q, bend, time) -> float:
    """Bounds the length of a moving point's way between two places [m].

    Args:
        p: The first place, shape (3,) [m].
        q: The second place, shape (3,) [m].
        bend: Bound on how fast the point's velocity changes [m/s^2].
        time: Time between the two places [s].
    """
    return apart(p, q) + bend * time * time / 3.0


@kernel(linked=True)
def longest_ways(point, span, bend):
    """Bounds the ways of n points from each of k + 1 looks to the next.

    Args:
        point: Where each point is at each look, shape (k + 1, n, 3) [m].
        span: Time between two looks, shape (k, n) [s].
        bend: Bounds on how fast the points' velocities change, shape (n,)
            [m/s^2].

    Returns:
        Bounds on the lengths of the ways, shape (k, n) [m].
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
def known_rooms(point, start, room, way, tolerance):
    """Bounds rooms without a look, and returns where that is not sufficient.

    A room is the excess of a distance over the level that it must keep. A point
    that has moved by x from its start has lost at most x of its room there.

    Args:
        point: Where each of n points is at each of k looks, shape (k, n, 3)
            [m].
        start: Where the room of each point is known, shape (n, 3) [m].
        room: The rooms at `start`, shape (n,) [m].
        way: Bounds on the ways before each look, and after the last where
            there is something after it, shape (k or k + 1, n) [m].
        tolerance: How far below zero each room may fall between two looks,
            shape (n,) [m].

    Returns:
        Lower bounds of the rooms, and the values beyond which the ways beside
        them are clear, shape (k, n) each [m].
    """
    k, n = point.shape[:2]
    known = np.empty((k, n))
    wanted = np.empty((k, n))
    for j in range(k):
        after = min(j + 1, len(way) - 1)
        for i in range(n):
            known[j, i] = room[i] - apart(start[i], point[j, i])
            half = 0.5 * max(way[j, i], way[after, i])
            wanted[j, i] = max(half - tolerance[i], 0.0)
    return known, wanted
