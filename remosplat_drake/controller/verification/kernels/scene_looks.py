"""Where spheres are along a path, and what that alone tells of their rooms."""

import numpy as np
from numba import njit

from remosplat_drake.controller.verification.kernels.between_looks import (
    bend_of,
    known_rooms,
    longest_ways,
)
from remosplat_drake.robot.kinematics import advance, body_poses, sphere_points


@njit(cache=True)
def look_along(robot, path, sphere, start, room, tolerance):
    """Places n spheres at the k times of a path.

    Args:
        robot: See `RobotModel.arrays`.
        path: See `StoppingPath.arrays`.
        sphere: Which spheres, shape (n,).
        start: Their centres where the path starts, shape (n, 3) [m].
        room: What their distances have above their levels there, (n,) [m].
        tolerance: Between two looks a room may be so far negative [m].

    Returns:
        Centres at the start and at the times, shape (k + 1, n, 3), link
        orientations at the times, (k, n, 3, 3), how fast the spheres'
        velocities may change, (n,), bounds on the ways between the looks,
        (k, n), and rooms that are known, and that are wanted, both as in
        `known_rooms`.
    """
    tree, body, p_BS = robot[0], robot[1][sphere], robot[2][sphere]
    q, u, n_base, times = path
    k, n = len(times), len(sphere)
    point = np.empty((k + 1, n, 3))
    R_WL = np.empty((k, n, 3, 3))
    span = np.empty((k, n))
    point[0] = start
    before = 0.0
    for j in range(k):
        q_then = advance(q, u, n_base, times[j])
        X_WB, _ = body_poses(*tree, q_then)  # pyright: ignore
        point[j + 1], R_WL[j] = sphere_points(X_WB, body, p_BS)
        span[j] = times[j] - before
        before = times[j]
    speed = np.abs(u)
    bend = np.empty(n)
    for i in range(n):
        bend[i] = bend_of(robot[4][sphere[i]], speed)
    way = longest_ways(point, span, bend)
    known, wanted = known_rooms(point[1:], start, room, way, tolerance)
    return point, R_WL, bend, way, known, wanted
