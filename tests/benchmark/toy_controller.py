"""A controller as a user might write one: resolved motion rates, scaled."""

import numpy as np

from remosplat_drake.controller.program.servo import servo_twist
from remosplat_drake.robot.pose_error import pose_error


def make(robot, field, X_WT, dt):
    def control(q, u_previous):
        state = robot.state(q)
        w, v = servo_twist(pose_error(state.X_WE, X_WT), 2.0, 0.3)
        J = np.vstack([state.Jw_WE, state.Jv_WE])
        damped = J @ J.T + 1e-3 * np.eye(6)
        u = J.T @ np.linalg.solve(damped, np.concatenate([w, v]))
        return u / max(1.0, np.max(np.abs(u) / robot.velocity_limit))

    return control


def make_too_fast(robot, field, X_WT, dt):
    return lambda q, u_previous: 2 * robot.velocity_limit


def make_shapeless(robot, field, X_WT, dt):
    return lambda q, u_previous: np.zeros(2)
