"""Whether a robot keeps off a map, at a place or all along a motion.

Between two looks a room falls to no less than (r_0 + r_1 - s) / 2, see
`verification/kernels/between_looks.py`. So a motion is looked at from coarse
to fine: where that is too little for some spheres, they are looked at half way.
"""

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.controller.verification.kernels.between_looks import (
    apart,
    bend_of,
    longest_way,
)
from remosplat_drake.robot.kinematics import advance, body_poses
from remosplat_drake.signals.compiled_map import ask

_HALVES = 10
"""How often the time between two looks is halved; what is unknown then is
refused."""

_SOME = 10
"""Number of spheres that are looked at before it is asked whether to go on."""

_MARGIN = 1e-6
"""By how much more than is wanted is asked for, against rounding [m]."""


@kernel
def is_off_the_map(robot, q, level, compiled):
    """Tells whether all spheres keep their clearances at a configuration.

    Args:
        robot: The robot as `RobotModel.arrays`.
        q: The configuration, shape (n_q,) [rad, m].
        level: Clearance that each sphere keeps, shape (n,) [m].
        compiled: The map, as `DistanceField.compiled`.
    """
    n = len(level)
    point = np.empty((n, 3))
    _place(robot, q, point)
    wanted, room = np.zeros(n), np.empty(n)
    # Mostly the hand, whose spheres are the last, is what has no room.
    for end in range(n, 0, -_SOME):
        for i in range(n):
            room[i] = -np.inf if end - _SOME <= i < end else np.inf
        if _look(robot, point, level, compiled, wanted, room) < 0.0:
            return False
    return True


@kernel
def keeps_off_the_map(robot, motion, level, compiled, looks, tolerance):
    """Tells whether all spheres keep their clearances on a motion.

    Args:
        robot: The robot as `RobotModel.arrays`.
        motion: Configuration q, the command u that is held for one second,
            and the number of base commands.
        level: Clearance that each sphere keeps, shape (n,) [m].
        compiled: The map, as `DistanceField.compiled`.
        looks: Into how many equal parts the first looks cut the motion.
        tolerance: How far below its level a clearance may fall [m].
    """
    q, u, n_base = motion
    n = len(level)
    speed = np.abs(u)
    bend, wanted = np.empty(n), np.empty(n)
    for i in range(n):
        bend[i] = bend_of(robot.hessian_bound[i], speed)
    # A stack, the end of the motion lowest: most that is not free ends there.
    time = np.zeros(looks + 1 + _HALVES)
    point = np.empty((len(time), n, 3))
    room = np.empty((len(time), n))
    for k in range(looks + 1):
        time[k] = 1.0 - k / looks
        _place(robot, advance(q, u, n_base, time[k]), point[k])
    for k in range(looks + 1):
        for i in range(n):
            before, way = 0.0, 0.0
            room[k, i] = -np.inf
            if k > 0:
                p, p_before = point[k, i], point[k - 1, i]
                room[k, i] = room[k - 1, i] - apart(p_before, p)
                before = longest_way(p_before, p, bend[i], 1.0 / looks)
            if k < looks:
                p, p_after = point[k, i], point[k + 1, i]
                way = longest_way(p, p_after, bend[i], 1.0 / looks)
            wanted[i] = max(0.5 * max(way, before) - tolerance, 0.0)
        least = _look(robot, point[k], level, compiled, wanted, room[k])
        if least < -tolerance:
            return False
    top = looks
    while top > 0:
        span = time[top - 1] - time[top]
        if not _want_more(point, room, top, bend, span, tolerance, wanted):
            top -= 1
            continue
        if top + 1 == len(time):
            return False
        time[top + 1] = time[top]
        time[top] += 0.5 * span
        for i in range(n):
            room[top + 1, i] = room[top, i]
            room[top, i] = np.inf if wanted[i] < 0.0 else -np.inf
            for c in range(3):
                point[top + 1, i, c] = point[top, i, c]
        _place(robot, advance(q, u, n_base, time[top]), point[top])
        least = _look(robot, point[top], level, compiled, wanted, room[top])
        if least < -tolerance:
            return False
        top += 1
    return True


@helper
def _want_more(point, room, top, bend, span, tolerance, wanted):
    """Tells whether a room may fall too low between the topmost two looks.

    Fills in what is wanted half way: -1 of spheres that are known to be clear.
    """
    is_open = False
    for i in range(len(bend)):
        p, p_next = point[top, i], point[top - 1, i]
        way = longest_way(p, p_next, bend[i], span)
        wanted[i] = -1.0
        if not room[top, i] + room[top - 1, i] - way >= -2.0 * tolerance:
            wanted[i] = max(0.25 * way - tolerance, 0.0)
            is_open = True
    return is_open


@helper
def _place(robot, q, point):
    """Fills in the spheres' centres in W, shape (n, 3) [m]."""
    X_WB, _ = body_poses(robot.tree, q)
    body, p_BS = robot.body_S, robot.p_LS
    for i in range(len(body)):
        X = X_WB[body[i]]
        for r in range(3):
            point[i, r] = X[r, 3]
            for c in range(3):
                point[i, r] += X[r, c] * p_BS[i, c]


@helper
def _look(robot, point, level, compiled, wanted, room):
    """Asks the map where a lower bound of a room is not as large as wanted.

    Puts the answers in, exact up to what is wanted, and returns the least.
    """
    radius, floor = robot.radius, robot.ignore_below
    n = len(room)
    asked, count = np.empty(n, np.int64), 0
    for i in range(n):
        if not room[i] > wanted[i]:
            asked[count] = i
            count += 1
    question, answer = np.empty((count, 5)), np.empty((count, 8))
    for row in range(count):
        i = asked[row]
        for c in range(3):
            question[row, c] = point[i, c]
        question[row, 3] = radius[i] + level[i] + wanted[i] + _MARGIN
        question[row, 4] = floor[i]
    ask(compiled, question, answer)
    least = np.inf
    for row in range(count):
        i = asked[row]
        room[i] = wanted[i] + _MARGIN
        if answer[row, 0] >= 0.0:
            room[i] = answer[row, 1] - radius[i] - level[i]
        least = min(least, room[i])
    return least
