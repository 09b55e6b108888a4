"""The position-based servo: computes a desired twist from a pose error."""

import numpy as np

from remosplat_drake.base.kernels import helper
from remosplat_drake.base.vectors import norm
from remosplat_drake.robot.pose_error import PoseError
from remosplat_drake.robot.target_arrays import place_on_line
from remosplat_drake.signals.target import Target

LINE_WIDTH = 0.02
"""Distance from a line beyond which an end effector does not move along the
line, but first moves back towards it [m]."""

LINE_SCALE = 0.05
"""Greatest value, on a line, of the error e by which costs are divided [m]."""

LINE_STIFFNESS = 50.0
"""Ratio of the cost of a deviation from a line to the cost of a speed that is
too low. Because the ratio is large, the end effector slows down near an
obstacle, and does not slide along the obstacle."""


def servo_twist(
    error: PoseError, gain: float, max_speed: float, onward: float = 0.0
) -> tuple[np.ndarray, np.ndarray]:
    """Computes the desired twist of E in W, proportional to the pose error.

    If the twist exceeds the speed bound, its angular and translational parts
    are multiplied by the same factor.

    Args:
        error: The pose error from the end effector E to the target T.
        gain: The paper's proportional gain beta [1/s].
        max_speed: Bound on the translational speed [m/s].
        onward: Length of the path after the target, along which the
            translational part keeps its speed [m].

    Returns:
        The angular velocity, shape (3,) [rad/s], and the translational
        velocity, shape (3,) [m/s], both in W.
    """
    turning, going = servo_gains(error.p_ET_W, gain, max_speed, onward)
    return turning * error.rotation_W, going * error.p_ET_W


def target_twist(
    X_WE: np.ndarray,
    target: Target,
    error: PoseError,
    gain: float,
    max_speed: float,
) -> tuple[np.ndarray, np.ndarray]:
    """Computes the desired twist of E in W for a target.

    Args:
        X_WE: Pose of the end effector, shape (4, 4).
        target: The target.
        error: The pose error of the target at X_WE.
        gain: The paper's proportional gain beta [1/s].
        max_speed: Bound on the translational speed [m/s].

    Returns:
        The angular velocity, shape (3,) [rad/s], and the translational
        velocity, shape (3,) [m/s], both in W.
    """
    if target.line is None:
        return servo_twist(error, gain, max_speed, target.onward)
    return line_twist(X_WE, target.arrays, gain, max_speed)


@helper
def servo_speed(p_ET_W, gain, max_speed):
    """Computes the gain with which the servo keeps its speed bound [1/s].

    Args:
        p_ET_W: Translation to the target, shape (3,) [m].
        gain: The gain without a bound [1/s].
        max_speed: Bound on the translational speed [m/s].
    """
    speed = gain * norm(p_ET_W)
    return gain * max_speed / speed if speed > max_speed else gain


@helper
def servo_gains(p_ET_W, gain, max_speed, onward):
    """Computes the gains on rotation and translation to a target [1/s].

    Args:
        p_ET_W: Translation to the target, shape (3,) [m].
        gain: The gain without a bound [1/s].
        max_speed: Bound on the translational speed [m/s].
        onward: Length of the path after the target [m].
    """
    slowed = servo_speed(p_ET_W, gain, max_speed)
    if onward == 0.0:
        return slowed, slowed
    left = norm(p_ET_W)
    speed = min(gain * (left + onward), max_speed)
    return slowed, speed / max(left, 1e-6)


@helper
def line_twist(X_WE, target, gain, max_speed):
    """Computes the twist that follows a line: along the line, and back to it.

    Args:
        X_WE: Pose of the end effector, shape (4, 4).
        target: The `TargetArrays` of a target with a line.
        gain: The proportional gain beta [1/s].
        max_speed: Bound of the translational speed, and of the speed back to
            the line [m/s].

    Returns:
        The angular velocity, shape (3,) [rad/s], and the translational
        velocity, shape (3,) [m/s], both in W.
    """
    along_W, left, p_ES_W, rotation_W, turn_W = place_on_line(X_WE, target)
    speed = min(target.speed, max_speed, gain * (left + target.onward))
    speed *= max(1.0 - norm(p_ES_W) / LINE_WIDTH, 0.0)
    back = servo_speed(p_ES_W, gain, max_speed)
    w, v = np.empty(3), np.empty(3)
    for c in range(3):
        w[c] = speed * turn_W[c] + back * rotation_W[c]
        v[c] = speed * along_W[c] + back * p_ES_W[c]
    return w, v


@helper
def error_scale(p_ET_E, target) -> float:
    """Computes the paper's error e, by which costs are divided [m].

    The error is the L1 distance to the target plus the length of the path after
    the target. It is at least a millimetre, so that the costs are finite at the
    target. On a line it is at most `LINE_SCALE`.

    Args:
        p_ET_E: Translation to the target in E, shape (3,) [m].
        target: The `TargetArrays`.
    """
    left = abs(p_ET_E[0]) + abs(p_ET_E[1]) + abs(p_ET_E[2])
    scale = max(left + target.onward, 1e-3)
    return min(scale, LINE_SCALE) if target.speed > 0.0 else scale
