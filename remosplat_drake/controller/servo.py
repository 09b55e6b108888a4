"""The position-based servo: from a pose error to a desired twist."""

import math

import numpy as np

from remosplat_drake.robot.pose_error import PoseError


def servo_twist(
    error: PoseError, gain: float, max_speed: float
) -> tuple[np.ndarray, np.ndarray]:
    """Computes the desired twist of E in W, proportional to the pose error.

    Where it is too fast, angular and translational part shrink together.

    Args:
        error: The pose error from the end effector E to the target T.
        gain: The paper's proportional gain beta [1/s].
        max_speed: Bound on the translational speed [m/s].

    Returns:
        The angular velocity, shape (3,) [rad/s], and the translational
        velocity, shape (3,) [m/s], both in W.
    """
    w, v = gain * error.rotation_W, gain * error.p_ET_W
    speed = math.hypot(*v)
    if speed > max_speed:
        scale = max_speed / speed
        w, v = w * scale, v * scale
    return w, v
