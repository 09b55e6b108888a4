"""Checks distances from a map at a configuration.

Balls around several spheres are checked first.
"""

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.returns import TRUTH, reals
from remosplat_drake.base.vectors import set_vector
from remosplat_drake.robot.kinematics import body_poses, sphere_points
from remosplat_drake.robot.self_collision.kernels.turning import point_to_world
from remosplat_drake.signals.compiled_map import (
    is_compiled,
    sphere_clearances,
)

_SOME = 4
"""Number of balls that are checked at a time."""

_MARGIN = 1e-6
"""Margin of queried distances against rounding [m]."""

_ROUNDING = 1e-9
"""Bound on rounding errors of distances [m]."""


@kernel(returns=TRUTH)
def is_off_the_map(space, line, X_WL):
    """Returns whether all spheres keep their clearances at a configuration.

    Args:
        space: The `SpaceArrays`.
        line: Identifier of the `PythonCalls` of its map.
        X_WL: Poses of all bodies, shape (b, 4, 4).
    """
    order, balls, item = space.ball_order, space.balls, space.work.parts.item
    for first in range(0, len(order), _SOME):
        count, spheres = min(len(order) - first, _SOME), 0
        room = _rooms_of(space, line, X_WL, order[first:], count)
        for k in range(count):
            i = order[first + k]
            if room[k] >= -_ROUNDING:
                continue
            for place in range(balls.first[i], balls.first[i + 1]):
                item[spheres] = balls.member[place]
                spheres += 1
        room = _rooms_of(space, line, X_WL, item, spheres)
        for k in range(spheres):
            if not room[k] >= -_ROUNDING:
                # These often collide the next time, too, so they are checked
                # first.
                for i in range(count):
                    order[i], order[first + i] = order[first + i], order[i]
                return False
    return True


@helper
def _rooms_of(space, line, X_WL, item, count):
    """Measures rooms at a configuration, exactly if they are not positive."""
    balls, queries = space.balls, space.work.queries
    for row in range(count):
        i = item[row]
        X = X_WL[balls.body[i]]
        queries.item[row], queries.wanted[row] = i, 0.0
        point_to_world(X, balls.p_LS[i], queries.p_WS[row])
        if not is_compiled(space.map):
            for r in range(3):
                set_vector(queries.R_WL[row, r], X[r])
    measure(space, line, count)
    return queries.room


@helper
def measure(space, line, count):
    """Measures the rooms of balls and spheres.

    Args:
        space: The `SpaceArrays`, with the queries in its working memory, all of
            balls or all of spheres.
        line: Identifier of the `PythonCalls` of its map.
        count: Number of queries.
    """
    balls, level, queries = space.balls, space.ball_level, space.work.queries
    groups = len(balls.first) - 1
    if count == 0:
        return
    placed = space.map, space.off, line
    item, room, reach = (
        queries.item[:count],
        queries.room[:count],
        queries.reach,
    )
    for row in range(count):
        reach[row] = level[item[row]] + max(queries.wanted[row], 0.0) + _MARGIN
    at, turned = queries.p_WS[:count], queries.R_WL[:count]
    if is_compiled(space.map):
        sphere_clearances(placed, balls, item, at, turned, reach, room)
    elif item[0] < groups:
        # Maps in Python support only spheres.
        room[:] = -np.inf
    else:
        sphere = item - groups
        sphere_clearances(
            placed, space.robot, sphere, at, turned, reach[:count], room
        )
    for row in range(count):
        room[row] -= level[item[row]]


@kernel(returns=reals(2))
def rooms(space, line, q, far):
    """Measures the rooms of spheres: clearances minus required ones.

    Args:
        space: The `SpaceArrays`.
        line: Identifier of the `PythonCalls` of its map.
        q: Configurations, shape (k, n_q) [rad, m].
        far: Value at which rooms are truncated [m].

    Returns:
        The rooms, shape (k, n) [m].
    """
    robot, n = space.robot, len(space.level)
    found, wanted = np.full((len(q), n), -np.inf), np.full(n, far)
    for k in range(len(q)):
        X_WL, _ = body_poses(robot.tree, q[k])
        at = sphere_points(X_WL, robot.body_S, robot.p_LS)
        look(space, line, at, wanted, found[k], 0.0)
        for i in range(n):
            if found[k, i] > far:
                found[k, i] = far
    return found


@helper
def look(space, line, at, wanted, room, least):
    """Queries the map for spheres whose lower bounds of rooms are too small.

    The room of a sphere is its clearance minus the required clearance.

    Args:
        space: The `SpaceArrays`.
        line: Identifier of the `PythonCalls` of its map.
        at: Centres of the spheres in W, shape (n, 3) [m], and the orientations
            of their links, shape (n, 3, 3).
        wanted: Rooms up to these values are computed exactly, shape (n,) [m].
        room: Input: lower bounds on the rooms; output: queried rooms, shape
            (n,) [m].
        least: Least permitted room [m].

    Returns:
        Whether all rooms are at least that.
    """
    p_WS, R_WL = at
    n, count = len(room), 0
    sphere = np.empty(n, np.int64)
    for i in range(n):
        if not room[i] > wanted[i]:
            sphere[count] = i
            count += 1
    if count == 0:
        return True
    sphere = sphere[:count]
    p, R = np.empty((count, 3)), np.empty((count, 3, 3))
    reach, found = np.empty(count), np.empty(count)
    for row in range(count):
        i = sphere[row]
        set_vector(p[row], p_WS[i])
        for r in range(3):
            set_vector(R[row, r], R_WL[i, r])
        reach[row] = space.level[i] + wanted[i] + _MARGIN
    placed = space.map, space.off, line
    sphere_clearances(placed, space.robot, sphere, p, R, reach, found)
    is_kept = True
    for row in range(count):
        i = sphere[row]
        room[i] = found[row] - space.level[i]
        is_kept &= room[i] >= least
    return is_kept
