"""Shortens a path that a search has found.

The path of a search is free, but seldom short. First, corners are omitted if
the motion without them is free. Then shortcuts between random points of the
path are tried (Geraerts and Overmars 2007). A shortcut must take less time than
the part that it replaces. A shorter length is not sufficient, since a base that
turns, drives and turns again may take longer.
"""

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.returns import REAL, WHOLE, reals, several
from remosplat_drake.controller.planning.kernels.collision_checks import (
    is_free_between,
)
from remosplat_drake.controller.planning.steering import (
    segment_command,
    waypoints,
)
from remosplat_drake.robot.kinematics import advance

_GAIN = 0.01
"""Least fraction of the time of a part that a shortcut must save."""


@kernel(returns=several(reals(2), WHOLE))
def shortened(space, line, corners, draws):
    """Shortens a free path without changing its ends.

    Args:
        space: The `SpaceArrays`.
        line: Number of the `PythonCalls` of the map.
        corners: The path's corners, shape (m, n_q) [rad, m].
        draws: Pairs of fractions of the path's time, shape (k, 2). A shortcut
            is tried between the two points of each pair.

    Returns:
        Corners of the shortened path, including the corners within its motions,
        shape (p, n_q), and the number of checked motions.
    """
    corners, checks = _without_detours(space, line, corners)
    corners = _split_segments(space, corners)
    times = _times(space, corners)
    for k in range(len(draws)):
        if len(corners) < 3:
            break
        total = times[-1]
        first = min(draws[k, 0], draws[k, 1])
        last = max(draws[k, 0], draws[k, 1])
        before, a = _place(space, corners, times, first * total)
        after, b = _place(space, corners, times, last * total)
        if after == before:
            continue
        now = (last - first) * total
        if motion_time(space, a, b) > (1.0 - _GAIN) * now:
            continue
        checks += 1
        if not is_free_between(space, line, a, b):
            continue
        corners = _replaced(space, corners, before, a, b, after)
        times = _times(space, corners)
    return corners, checks


@kernel(returns=REAL)
def motion_time(space, a, b):
    """Returns the duration of a motion at the limits of velocity [s].

    Args:
        space: The `SpaceArrays`.
        a: Configuration at the start, shape (n_q,) [rad, m].
        b: Configuration at the end, shape (n_q,) [rad, m].
    """
    robot, time = space.robot, 0.0
    way = waypoints(a, b, robot.n_base, space.backing)
    for k in range(len(way) - 1):
        u = segment_command(way[k], way[k + 1], robot.n_base)
        longest = 0.0
        for j in range(len(u)):
            longest = max(longest, abs(u[j]) / robot.velocity_limit[j])
        time += longest
    return time


@helper
def _without_detours(space, line, corners):
    """Omits corners: first many together, then fewer.

    Returns:
        The remaining corners, and the number of checked motions.
    """
    m = len(corners)
    times = _times(space, corners)
    is_kept = np.ones(m, np.bool_)
    # The stack contains parts of the path. A part is halved if the motion
    # without its corners is not free.
    parts = np.empty((m + 1, 2), np.int64)
    parts[0, 0], parts[0, 1], top, checks = 0, m - 1, 1, 0
    while top > 0:
        top -= 1
        i, j = parts[top, 0], parts[top, 1]
        if j - i < 2:
            continue
        a, b = corners[i], corners[j]
        if motion_time(space, a, b) <= times[j] - times[i]:
            checks += 1
            if is_free_between(space, line, a, b):
                is_kept[i + 1 : j] = False
                continue
        half = (i + j) // 2
        parts[top, 0], parts[top, 1] = half, j
        parts[top + 1, 0], parts[top + 1, 1] = i, half
        top += 2
    count = 0
    kept = np.empty(corners.shape)
    for i in range(m):
        if is_kept[i]:
            kept[count] = corners[i]
            count += 1
    return kept[:count].copy(), checks


@helper
def _split_segments(space, corners):
    """Returns all corners of a path, including those of its motions."""
    parts, count = 1, 1
    for k in range(len(corners) - 1):
        n_base, backing = space.robot.n_base, space.backing
        way = waypoints(corners[k], corners[k + 1], n_base, backing)
        parts += len(way) - 1
    result = np.empty((parts, corners.shape[1]))
    result[0] = corners[0]
    for k in range(len(corners) - 1):
        n_base, backing = space.robot.n_base, space.backing
        way = waypoints(corners[k], corners[k + 1], n_base, backing)
        for i in range(1, len(way)):
            result[count] = way[i]
            count += 1
    return result


@helper
def _times(space, corners):
    """Returns the time at each corner, shape (m,) [s]."""
    times = np.zeros(len(corners))
    for k in range(1, len(corners)):
        way = motion_time(space, corners[k - 1], corners[k])
        times[k] = times[k - 1] + way
    return times


@helper
def _place(space, corners, times, time):
    """Returns the segment and the configuration of a path at a time."""
    k = 0
    while k < len(times) - 2 and times[k + 1] <= time:
        k += 1
    n_base, span = space.robot.n_base, times[k + 1] - times[k]
    share = (time - times[k]) / span if span > 0.0 else 0.0
    u = segment_command(corners[k], corners[k + 1], n_base)
    return k, advance(corners[k], u, n_base, share)


@helper
def _replaced(space, corners, before, a, b, after):
    """Returns the corners with a shortcut from a to b.

    Args:
        space: The `SpaceArrays`.
        corners: The corners, shape (m, n_q).
        before: Index of the corner before a.
        a: Start of the shortcut.
        b: End of the shortcut.
        after: Index of the corner before b.
    """
    way = waypoints(a, b, space.robot.n_base, space.backing)
    head, tail = before + 1, len(corners) - after - 1
    result = np.empty((head + len(way) + tail, corners.shape[1]))
    result[:head] = corners[:head]
    result[head : head + len(way)] = way
    result[head + len(way) :] = corners[after + 1 :]
    return result
