"""The position-based servo: from a pose error to a desired twist."""

import math

import numpy as np

from remosplat_drake.robot.pose_error import PoseError


def servo_twist(
    error: PoseError, gain: float, max_speed: float
) -> tuple[np.ndarray, np.ndarray]:
    """Desired velocity of E in W: proportional, limited as a whole twist.

    Args:
        error: See `PoseError`.
        gain: The paper's beta [1/s].
        max_speed: Bound on the translational speed [m/s].

    Returns:
        Angular (3,) and translational (3,) velocity [rad/s, m/s].
    """
    w, v = gain * error.rotation_W, gain * error.p_ET_W
    speed = math.hypot(*v)
    if speed > max_speed:
        scale = max_speed / speed
        w, v = w * scale, v * scale
    return w, v
