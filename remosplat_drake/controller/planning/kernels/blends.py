"""Rounds off the corners of a path, as far as the blends are free.

A blend is a parabola from a point before the corner to a point at the same
distance after the corner. The corner is its control point. Kunz and Stilman
(2012) use circles.
"""

import math

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.returns import reals
from remosplat_drake.controller.planning.kernels.collision_checks import (
    is_free_between,
)

_TURN = 0.15
"""Largest turn between two pieces of a blend [rad]."""

_MOST = 1 + math.ceil(math.pi / _TURN)
"""Largest number of pieces of a blend."""

_TRIES = 4
"""Number of times that a blend is halved if it is not collision-free."""


@kernel(returns=reals(2))
def blended(space, line, corners, longest):
    """Replaces the corners of a path by collision-free blends.

    Args:
        space: The `SpaceArrays`.
        line: Number of the `PythonCalls` of the map.
        corners: Corners of a free path, shape (k, n_q) [rad, m]. Consecutive
            corners must differ.
        longest: Largest distance in q from a corner to the ends of its blend. A
            radian counts like a metre.

    Returns:
        Corners of the blended path, shape (m, n_q) [rad, m].
    """
    k, n_q = corners.shape
    points, count = np.empty((k * (_MOST + 1), n_q)), 1
    to, onward = np.empty(n_q), np.empty(n_q)
    points[0] = corners[0]
    for i in range(1, k - 1):
        way = _unit(corners[i - 1], corners[i], to)
        reach = min(0.5 * way, 0.5 * _unit(corners[i + 1], corners[i], onward))
        reach, cosine = min(reach, longest), 0.0
        for j in range(n_q):
            cosine -= to[j] * onward[j]
        turn = math.acos(min(max(cosine, -1.0), 1.0))
        pieces = math.ceil(turn / _TURN) + 1
        for _ in range(_TRIES):
            blend = points[count : count + pieces + 1]
            _write_blend(corners[i], reach, to, onward, blend)
            if _is_open(space, line, blend):
                count += pieces + 1
                break
            reach *= 0.5
        else:
            points[count] = corners[i]
            count += 1
    points[count] = corners[k - 1]
    return points[: count + 1].copy()


@helper
def _unit(place, corner, direction):
    """Writes the direction from a corner to a point; returns the distance."""
    square = 0.0
    for j in range(len(corner)):
        direction[j] = place[j] - corner[j]
        square += direction[j] * direction[j]
    length = math.sqrt(square)
    for j in range(len(corner)):
        direction[j] /= length
    return length


@helper
def _write_blend(corner, reach, to, onward, blend):
    """Writes the points of a blend.

    The parabola has three control points: the point at the distance `reach`
    from the corner towards the previous corner, the corner, and the point at
    the distance `reach` towards the next corner.
    """
    pieces = len(blend) - 1
    for k in range(pieces + 1):
        share = k / pieces
        before, after = reach * (1.0 - share) ** 2, reach * share**2
        for j in range(len(corner)):
            blend[k, j] = corner[j] + before * to[j] + after * onward[j]


@helper
def _is_open(space, line, points):
    """Whether a blend is free; its first point is on the path and free."""
    for k in range(len(points) - 1):
        if not is_free_between(space, line, points[k], points[k + 1]):
            return False
    return True
