"""Whether a robot keeps off a map, at a place or all along a motion.

Between two looks a room falls to no less than (r_0 + r_1 - s) / 2, see
`verification/kernels/between_looks.py`. So a motion is looked at from coarse
to fine: where that is too little for some spheres, they are looked at half way.
"""

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.returns import TRUTH, reals
from remosplat_drake.base.vectors import set_vector
from remosplat_drake.controller.verification.kernels.between_looks import (
    TOLERANCE,
    apart,
    bend_of,
    longest_way,
)
from remosplat_drake.robot.kinematics import (
    advance,
    body_poses,
    place_points,
    sphere_points,
)
from remosplat_drake.signals.compiled_map import (
    is_lipschitz,
    sphere_clearances,
)

_HALVES = 10
"""How often the time between two looks is halved; what is unknown then is
refused."""

_SOME = 10
"""Number of spheres that are looked at before it is asked whether to go on."""

_MARGIN = 1e-6
"""By how much more than is wanted is asked for, against rounding [m]."""


_ROUNDING = 1e-9
"""Rounding errors of distances [m]."""


@kernel(returns=TRUTH)
def is_off_the_map(space, line, X_WL):
    """Tells whether all spheres keep their clearances at a configuration.

    Args:
        space: The `SpaceArrays`.
        line: Number of the `PythonCalls` of its map.
        X_WL: Poses of all bodies, shape (b, 4, 4).
    """
    robot, n = space.robot, len(space.level)
    at = sphere_points(X_WL, robot.body_S, robot.p_LS)
    wanted, room = np.zeros(n), np.empty(n)
    # Mostly the hand, whose spheres are the last, is what has no room.
    for end in range(n, 0, -_SOME):
        for i in range(n):
            room[i] = -np.inf if end - _SOME <= i < end else np.inf
        if not _look(space, line, at, wanted, room, -_ROUNDING):
            return False
    return True


@kernel(returns=reals(2))
def rooms(space, line, q, far):
    """Measures what spheres have above the clearances that they keep.

    Args:
        space: The `SpaceArrays`.
        line: Number of the `PythonCalls` of its map.
        q: Configurations, shape (k, n_q) [rad, m].
        far: Room at which rooms are cut off [m].

    Returns:
        The rooms, shape (k, n) [m].
    """
    robot, n = space.robot, len(space.level)
    found, wanted = np.full((len(q), n), -np.inf), np.full(n, far)
    for k in range(len(q)):
        X_WL, _ = body_poses(robot.tree, q[k])
        at = sphere_points(X_WL, robot.body_S, robot.p_LS)
        _look(space, line, at, wanted, found[k], 0.0)
        for i in range(n):
            if found[k, i] > far:
                found[k, i] = far
    return found


@kernel(returns=TRUTH)
def keeps_off_the_map(space, line, q, u, looks):
    """Tells whether all spheres keep their clearances on a motion.

    They keep them less verification's tolerance. Of a map that is not
    1-Lipschitz only the first looks are known.

    Args:
        space: The `SpaceArrays`.
        line: Number of the `PythonCalls` of its map.
        q: Configuration at which it starts, shape (n_q,) [rad, m].
        u: The command, which is held for a second, shape (n_u,).
        looks: Into how many equal parts the first looks cut the motion.
    """
    robot, n = space.robot, len(space.level)
    n_base, knows_between = robot.n_base, is_lipschitz(space.map)
    speed = np.abs(u)
    bend, wanted = np.empty(n), np.empty(n)
    for i in range(n):
        bend[i] = bend_of(robot.hessian_bound[i], speed)
    # A stack, the end of the motion lowest: most that is not free ends there.
    time = np.zeros(looks + 1 + _HALVES)
    point = np.empty((len(time), n, 3))
    R_WL, room = np.empty((looks + 1, n, 3, 3)), np.empty((len(time), n))
    for k in range(looks + 1):
        time[k] = 1.0 - k / looks
        X_WL, _ = body_poses(robot.tree, advance(q, u, n_base, time[k]))
        place_points(X_WL, robot.body_S, robot.p_LS, point[k], R_WL[k])
    for k in range(looks + 1):
        for i in range(n):
            before, way = 0.0, 0.0
            room[k, i] = -np.inf
            if k > 0 and knows_between:
                p, p_before = point[k, i], point[k - 1, i]
                room[k, i] = room[k - 1, i] - apart(p_before, p)
                before = longest_way(p_before, p, bend[i], 1.0 / looks)
            if k < looks:
                p, p_after = point[k, i], point[k + 1, i]
                way = longest_way(p, p_after, bend[i], 1.0 / looks)
            wanted[i] = max(0.5 * max(way, before) - TOLERANCE, 0.0)
        at = point[k], R_WL[k]
        if not _look(space, line, at, wanted, room[k], -TOLERANCE):
            return False
    top = looks
    while top > 0 and knows_between:
        span = time[top - 1] - time[top]
        if not _want_more(point, room, top, bend, span, wanted):
            top -= 1
            continue
        if top + 1 == len(time):
            return False
        time[top + 1] = time[top]
        time[top] += 0.5 * span
        for i in range(n):
            room[top + 1, i] = room[top, i]
            room[top, i] = np.inf if wanted[i] < 0.0 else -np.inf
            set_vector(point[top + 1, i], point[top, i])
        X_WL, _ = body_poses(robot.tree, advance(q, u, n_base, time[top]))
        place_points(X_WL, robot.body_S, robot.p_LS, point[top], R_WL[0])
        at = point[top], R_WL[0]
        if not _look(space, line, at, wanted, room[top], -TOLERANCE):
            return False
        top += 1
    return True


@helper
def _want_more(point, room, top, bend, span, wanted):
    """Tells whether a room may fall too low between the topmost two looks.

    Fills in what is wanted half way: -1 of spheres that are known to be clear.
    """
    is_open = False
    for i in range(len(bend)):
        p, p_next = point[top, i], point[top - 1, i]
        way = longest_way(p, p_next, bend[i], span)
        wanted[i] = -1.0
        if not room[top, i] + room[top - 1, i] - way >= -2.0 * TOLERANCE:
            wanted[i] = max(0.25 * way - TOLERANCE, 0.0)
            is_open = True
    return is_open


@helper
def _look(space, line, at, wanted, room, least):
    """Asks the map where a lower bound of a room is not as large as wanted.

    Puts the answers in, exact up to what is wanted, and tells whether all of
    them are at least as large as `least` [m].
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
