"""Checks the distances of spheres from a map in a configuration.

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

_EXTRA_REACH = 1e-6
"""Distance by which queries reach farther, against rounding errors [m]."""

_ROUNDING = 1e-9
"""Bound of rounding errors of distances [m]."""


@kernel(returns=TRUTH)
def is_off_the_map(space, line, X_WL):
    """Returns whether all spheres keep their clearances in a configuration.

    Args:
        space: The `SpaceArrays`.
        line: Number of the `PythonCalls` of the map.
        X_WL: Poses of all bodies, shape (b, 4, 4).
    """
    order, balls, item = space.ball_order, space.balls, space.work.parts.item
    for first in range(0, len(order), _SOME):
        count, spheres = min(len(order) - first, _SOME), 0
        margin = _margins_at(space, line, X_WL, order[first:], count)
        for k in range(count):
            i = order[first + k]
            if margin[k] >= -_ROUNDING:
                continue
            for place in range(balls.first[i], balls.first[i + 1]):
                item[spheres] = balls.member[place]
                spheres += 1
        margin = _margins_at(space, line, X_WL, item, spheres)
        for k in range(spheres):
            if not margin[k] >= -_ROUNDING:
                # These balls often collide in the next configuration, too, so
                # they are checked first from now on.
                for i in range(count):
                    order[i], order[first + i] = order[first + i], order[i]
                return False
    return True


@helper
def _margins_at(space, line, X_WL, item, count):
    """Measures margins in a configuration, exactly if they are not positive."""
    balls, queries = space.balls, space.work.queries
    for row in range(count):
        i = item[row]
        X = X_WL[balls.body[i]]
        queries.item[row], queries.wanted[row] = i, 0.0
        point_to_world(X, balls.p_LS[i], queries.p_WS[row])
        if not is_compiled(space.map):
            for r in range(3):
                set_vector(queries.R_WL[row, r], X[r])
    measure_margins(space, line, count)
    return queries.margin


@helper
def measure_margins(space, line, count):
    """Measures the margins of balls and spheres.

    Args:
        space: The `SpaceArrays`, whose working memory contains the queries.
            Either all queries are of balls, or all are of spheres.
        line: Number of the `PythonCalls` of the map.
        count: Number of queries.
    """
    balls, level, queries = space.balls, space.ball_level, space.work.queries
    groups = len(balls.first) - 1
    if count == 0:
        return
    placed = space.map, space.off, line
    item, margin, reach = (
        queries.item[:count],
        queries.margin[:count],
        queries.reach,
    )
    for row in range(count):
        reach[row] = (
            level[item[row]] + max(queries.wanted[row], 0.0) + _EXTRA_REACH
        )
    at, turned = queries.p_WS[:count], queries.R_WL[:count]
    if is_compiled(space.map):
        sphere_clearances(placed, balls, item, at, turned, reach, margin)
    elif item[0] < groups:
        # Maps in Python support only spheres.
        margin[:] = -np.inf
    else:
        sphere = item - groups
        sphere_clearances(
            placed, space.robot, sphere, at, turned, reach[:count], margin
        )
    for row in range(count):
        margin[row] -= level[item[row]]


@kernel(returns=reals(2))
def sphere_margins(space, line, q, far):
    """Measures the margins of spheres: clearances minus required clearances.

    Args:
        space: The `SpaceArrays`.
        line: Number of the `PythonCalls` of the map.
        q: Configurations, shape (k, n_q) [rad, m].
        far: Value at which margins are truncated [m].

    Returns:
        The margins, shape (k, n) [m].
    """
    robot, n = space.robot, len(space.level)
    found, wanted = np.full((len(q), n), -np.inf), np.full(n, far)
    for k in range(len(q)):
        X_WL, _ = body_poses(robot.tree, q[k])
        at = sphere_points(X_WL, robot.body_S, robot.p_LS)
        query_margins(space, line, at, wanted, found[k], 0.0)
        for i in range(n):
            if found[k, i] > far:
                found[k, i] = far
    return found


@helper
def query_margins(space, line, at, wanted, margin, least):
    """Queries the map for spheres whose lower bounds of margins are too small.

    The margin of a sphere is its clearance minus the required clearance.

    Args:
        space: The `SpaceArrays`.
        line: Number of the `PythonCalls` of the map.
        at: Centres of the spheres in W, shape (n, 3) [m], and the orientations
            of their links, shape (n, 3, 3).
        wanted: Margins up to these values are computed exactly, shape (n,) [m].
        margin: Input: lower bounds of the margins. Output: the queried margins,
            shape (n,) [m].
        least: Least permitted margin [m].

    Returns:
        Whether all margins are at least `least`.
    """
    p_WS, R_WL = at
    n, count = len(margin), 0
    sphere = np.empty(n, np.int64)
    for i in range(n):
        if not margin[i] > wanted[i]:
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
        reach[row] = space.level[i] + wanted[i] + _EXTRA_REACH
    placed = space.map, space.off, line
    sphere_clearances(placed, space.robot, sphere, p, R, reach, found)
    is_kept = True
    for row in range(count):
        i = sphere[row]
        margin[i] = found[row] - space.level[i]
        is_kept &= margin[i] >= least
    return is_kept
