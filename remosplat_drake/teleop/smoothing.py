"""Computes motion to a goal with bounded speed and acceleration.

Time is discrete: a velocity is constant for dt, and the norm of its change is
at most acceleration * dt.
"""

import math

import numpy as np
from pydrake.common.eigen_geometry import AngleAxis
from pydrake.math import RotationMatrix

from remosplat_drake.robot.pose_error import rotation_vector

_COMMITMENT = 0.2
"""A rotation in progress is reversed only if the reversal shortens the
remaining rotation by more than this angle [rad]."""


def braking_speed(distance: float, acceleration: float, dt: float) -> float:
    """Returns the largest speed from which braking takes a given distance.

    A speed of n + f steps of acceleration * dt, with f in [0, 1), brakes over
    (n (n + 1) / 2 + (n + 1) f) * acceleration * dt^2; this function is the
    inverse.

    Args:
        distance: Distance to brake over, not negative [m or rad].
        acceleration: Greatest deceleration [m/s^2 or rad/s^2].
        dt: Length of a step [s].

    Returns:
        The speed [m/s or rad/s].
    """
    change = acceleration * dt
    steps = distance / (change * dt)
    n = math.floor(0.5 * (math.sqrt(1.0 + 8.0 * steps) - 1.0))
    return change * (n + (steps - 0.5 * n * (n + 1)) / (n + 1))


def velocity_towards(
    offset: np.ndarray, max_speed: float, acceleration: float, dt: float
) -> np.ndarray:
    """Returns the fastest velocity from which braking can still end at a goal.

    Args:
        offset: Vector from the present position to the goal, shape (3,) [m or
            rad].
        max_speed: Greatest speed [m/s or rad/s].
        acceleration: Greatest deceleration [m/s^2 or rad/s^2].
        dt: Length of a step [s].

    Returns:
        A velocity straight to the goal, shape (3,) [m/s or rad/s].
    """
    distance = math.hypot(*offset)
    if distance == 0.0:
        return np.zeros(3)
    speed = min(max_speed, braking_speed(distance, acceleration, dt))
    return offset * (speed / distance)


def change_velocity(
    before: np.ndarray, wanted: np.ndarray, max_change: float
) -> np.ndarray:
    """Returns the present velocity, changed towards a desired velocity.

    Args:
        before: The present velocity, shape (3,).
        wanted: The desired velocity, shape (3,).
        max_change: Largest norm of the change of velocity.
    """
    change = wanted - before
    size = math.hypot(*change)
    if size <= max_change:
        return wanted
    return before + change * (max_change / size)


def limit_norm(vector: np.ndarray, bound: float) -> np.ndarray:
    """Scales a vector down to a given norm if it is longer."""
    size = math.hypot(*vector)
    return vector if size <= bound else vector * (bound / size)


def rotation_to_go(
    R_WT: np.ndarray,
    R_WT_goal: np.ndarray,
    w_WT: np.ndarray,
    acceleration: float,
) -> np.ndarray:
    """Returns the remaining rotation to a goal, as a rotation vector in W.

    This is the shorter of the two possible rotations, with an exception: if the
    target already rotates, and reversal would take longer, the rotation
    continues in its direction. A goal that oscillates around half a turn
    therefore does not reverse the rotation again and again.

    Args:
        R_WT: The target's present rotation, shape (3, 3).
        R_WT_goal: The target's rotation at the goal, shape (3, 3).
        w_WT: The target's angular velocity in W, shape (3,) [rad/s].
        acceleration: Greatest angular deceleration [rad/s^2].

    Returns:
        Angle times axis, shape (3,) [rad].
    """
    shorter = rotation_vector(R_WT_goal @ R_WT.T)
    angle = math.hypot(*shorter)
    if angle == 0.0 or w_WT @ shorter >= 0.0:
        return shorter
    longer = 2.0 * math.pi - angle
    stopping = 0.5 * float(w_WT @ w_WT) / acceleration
    if longer > angle + 2.0 * stopping + _COMMITMENT:
        return shorter
    return shorter * (-longer / angle)


def rotated(R_WT: np.ndarray, rotation_W: np.ndarray) -> np.ndarray:
    """Turns R_WT by a rotation vector in W [rad]; the result is orthonormal."""
    angle = math.hypot(*rotation_W)
    if angle == 0.0:
        return R_WT
    turn = RotationMatrix(AngleAxis(angle, rotation_W / angle))
    return RotationMatrix.ProjectToRotationMatrix(turn.matrix() @ R_WT).matrix()
