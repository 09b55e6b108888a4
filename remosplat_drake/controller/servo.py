"""The position-based servo: from a pose error to a desired twist."""

import numpy as np

from remosplat_drake.base.kernels import helper
from remosplat_drake.base.vectors import norm
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
    gain = servo_speed(error.p_ET_W, gain, max_speed)
    return gain * error.rotation_W, gain * error.p_ET_W


@helper
def servo_speed(p_ET_W, gain, max_speed):
    """Computes the gain with which the servo stays within its bound [1/s].

    Args:
        p_ET_W: Translation to the target, shape (3,) [m].
        gain: The gain without the bound [1/s].
        max_speed: Bound on the translational speed [m/s].
    """
    speed = gain * norm(p_ET_W)
    return gain * max_speed / speed if speed > max_speed else gain
