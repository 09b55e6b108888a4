"""Places spheres along a path, and computes bounds of their clearances."""

import numpy as np

from remosplat_drake.base.kernels import helper
from remosplat_drake.base.vectors import set_vector
from remosplat_drake.controller.verification.kernels.between_samples import (
    bend_of,
    longest_ways,
    margin_bounds,
)
from remosplat_drake.controller.verification.kernels.places import (
    peak_speed,
    place,
)
from remosplat_drake.robot.kinematics import body_poses, sphere_points


@helper
def sample_path(robot, path, sphere, start, margin, tolerance):
    """Places n spheres at the k times of a path.

    Args:
        robot: The `RobotArrays`.
        path: The `PathArrays`.
        sphere: Indices of the spheres, shape (n,).
        start: Centres of the spheres in W at the start of the path, shape
            (n, 3) [m].
        margin: Margins of the spheres (clearances minus levels) at the start of
            the path, shape (n,) [m].
        tolerance: Amount by which each margin may fall below zero between two
            samples, shape (n,) [m].

    Returns:
        Six arrays: the centres in W at the start and at the times, shape (k +
        1, n, 3) [m]; the orientations of the spheres' links at the times, shape
        (k, n, 3, 3); bounds of the spheres' accelerations, shape (n,) [m/s^2];
        bounds of the lengths of the paths between the samples, shape (k, n)
        [m]; and the two results of `margin_bounds`, both of shape (k, n) [m].
    """
    tree, body, p_BS = robot.tree, robot.body_S[sphere], robot.p_LS[sphere]
    times = path.times
    k, n = len(times), len(sphere)
    point = np.empty((k + 1, n, 3))
    R_WL = np.empty((k, n, 3, 3))
    span = np.empty((k, n))
    for i in range(n):
        set_vector(point[0, i], start[i])
    before = 0.0
    for j in range(k):
        q_then = place(path, times[j])
        X_WB, _ = body_poses(tree, q_then)
        p_WS, R_WS = sphere_points(X_WB, body, p_BS)
        for i in range(n):
            set_vector(point[j + 1, i], p_WS[i])
            for r in range(3):
                set_vector(R_WL[j, i, r], R_WS[i, r])
            span[j, i] = times[j] - before
        before = times[j]
    speed = peak_speed(path.rates)
    bend = np.empty(n)
    for i in range(n):
        bend[i] = bend_of(robot.hessian_bound[sphere[i]], speed)
    way = longest_ways(point, span, bend)
    known, wanted = margin_bounds(point[1:], start, margin, way, tolerance)
    return point, R_WL, bend, way, known, wanted
