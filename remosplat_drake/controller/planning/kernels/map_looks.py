"""Whether a robot keeps off a map, at a place or all along a motion.

Between two looks a room falls to no less than (r_0 + r_1 - s) / 2, see
`verification/kernels/between_looks.py`. So a motion is looked at from coarse
to fine: where that is too little for some spheres, they are looked at half way.
"""

import numpy as np
from numba import njit

from remosplat_drake.controller.verification.kernels.between_looks import (
    apart,
    bend_of,
    longest_way,
)
from remosplat_drake.robot.kinematics import advance, body_poses, sphere_points
from remosplat_drake.signals.compiled_map import ask

_HALVES = 10
"""How often the time between two looks is halved; what is unknown then is
refused."""

_SOME = 10
"""Number of spheres that are looked at before it is asked whether to go on."""

_MARGIN = 1e-6
"""By how much more than is wanted is asked for, against rounding [m]."""


@njit(cache=True, nogil=True)
def is_off_the_map(robot, q, level, compiled):
    """Tells whether all spheres keep their clearances at a configuration.

    Args:
        robot: The robot as `RobotModel.arrays`.
        q: The configuration, shape (n_q,) [rad, m].
        level: Clearance that each sphere keeps, shape (n,) [m].
        compiled: The map, as `DistanceField.compiled`.
    """
    n = len(level)
    point = _centres(robot, q)
    wanted = np.zeros(n)
    # Mostly the hand, whose spheres are the last, is what has no room.
    for end in range(n, 0, -_SOME):
        room = np.full(n, np.inf)
        room[max(end - _SOME, 0) : end] = -np.inf
        if _look(robot, point, level, compiled, wanted, room) < 0.0:
            return False
    return True


@njit(cache=True, nogil=True)
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
    bend = np.array([bend_of(robot[4][i], speed) for i in range(n)])
    # A stack, the end of the motion lowest: most that is not free ends there.
    time = np.zeros(looks + 1 + _HALVES)
    point = np.empty((len(time), n, 3))
    room = np.full((len(time), n), -np.inf)
    wanted = np.zeros(n)
    for k in range(looks + 1):
        time[k] = 1.0 - k / looks
        point[k] = _centres(robot, advance(q, u, n_base, time[k]))
    for k in range(looks + 1):
        for i in range(n):
            way = 0.0
            for j in range(max(k - 1, 0), min(k + 1, looks)):
                two = point[j, i], point[j + 1, i]
                way = max(way, longest_way(*two, bend[i], 1.0 / looks))
            wanted[i] = max(0.5 * way - tolerance, 0.0)
            if k > 0:
                moved = apart(point[k - 1, i], point[k, i])
                room[k, i] = room[k - 1, i] - moved
        if _look(robot, point[k], level, compiled, wanted, room[k]) < -tolerance:
            return False
    top = looks
    while top > 0:
        span = time[top - 1] - time[top]
        is_open = False
        for i in range(n):
            two = point[top, i], point[top - 1, i]
            way = longest_way(*two, bend[i], span)
            wanted[i] = max(0.25 * way - tolerance, 0.0)
            low = 0.5 * (room[top, i] + room[top - 1, i] - way)
            if low >= -tolerance:
                wanted[i] = -np.inf  # Nothing more is asked of this sphere.
            else:
                is_open = True
        if not is_open:
            top -= 1
            continue
        if top + 1 == len(time):
            return False
        time[top + 1], point[top + 1] = time[top], point[top]
        room[top + 1] = room[top]
        time[top] += 0.5 * span
        point[top] = _centres(robot, advance(q, u, n_base, time[top]))
        room[top] = np.where(np.isinf(wanted), np.inf, -np.inf)
        if _look(robot, point[top], level, compiled, wanted, room[top]) < -(
            tolerance
        ):
            return False
        top += 1
    return True


@njit(cache=True, nogil=True)
def _centres(robot, q):
    """The spheres' centres in W, shape (n, 3) [m]."""
    X_WB, _ = body_poses(*robot[0], q)  # pyright: ignore
    return sphere_points(X_WB, robot[1], robot[2])[0]


@njit(cache=True, nogil=True)
def _look(robot, point, level, compiled, wanted, room):
    """Asks the map where a lower bound of a room is not as large as wanted.

    Puts the answers in, exact up to what is wanted, and returns the least.
    """
    radius, floor = robot[3], robot[5]
    asked = np.flatnonzero(~(room > wanted))
    question = np.empty((len(asked), 5))
    for row in range(len(asked)):
        i = asked[row]
        question[row, :3] = point[i]
        question[row, 3] = radius[i] + level[i] + wanted[i] + _MARGIN
        question[row, 4] = floor[i]
    answer = np.empty((len(asked), 8))
    ask(compiled, question, answer)
    least = np.inf
    for row in range(len(asked)):
        i = asked[row]
        room[i] = wanted[i] + _MARGIN
        if answer[row, 0] >= 0.0:
            room[i] = answer[row, 1] - radius[i] - level[i]
        least = min(least, room[i])
    return least
