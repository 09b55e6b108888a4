"""Targets packed for kernels: pose errors, and positions on a line."""

import math
from typing import NamedTuple

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.returns import REAL, reals, several
from remosplat_drake.base.vectors import cross, dot, norm, rotation
from remosplat_drake.robot.pose_error import error_arrays, rotation_vector


class TargetArrays(NamedTuple):
    """A `Target`, packed for kernels.

    Attributes:
        X_WT: `Target.X_WT`, shape (4, 4).
        weights: `Target.weights`, shape (6,).
        onward: `Target.onward` [m].
        X_WA: Pose at which its line starts, shape (4, 4).
        speed: Speed along the line [m/s]; zero without one.
    """

    X_WT: np.ndarray
    weights: np.ndarray
    onward: float
    X_WA: np.ndarray
    speed: float


class AimArrays(NamedTuple):
    """An `Aim` with k targets, packed for kernels.

    Attributes:
        effector: Index of the end effector of each target, shape (k,).
        X_WT: `TargetArrays.X_WT` of each, shape (k, 4, 4).
        weights: `TargetArrays.weights` of each, shape (k, 6).
        onward: `TargetArrays.onward` of each, shape (k,) [m].
        X_WA: `TargetArrays.X_WA` of each, shape (k, 4, 4).
        speed: `TargetArrays.speed` of each, shape (k,) [m/s].
        by_path: Whether `Aim.q` is given, which only a planned path reaches.
    """

    effector: np.ndarray
    X_WT: np.ndarray
    weights: np.ndarray
    onward: np.ndarray
    X_WA: np.ndarray
    speed: np.ndarray
    by_path: bool


@helper
def target_of(aim, i) -> TargetArrays:
    """Returns a target of an aim.

    Args:
        aim: The `AimArrays`.
        i: Index of the target.
    """
    return TargetArrays(
        aim.X_WT[i], aim.weights[i], aim.onward[i], aim.X_WA[i], aim.speed[i]
    )


@kernel(returns=several(reals(1), reals(1), reals(1)))
def constrained_error(X_WE, target):
    """Computes a `PoseError`'s attributes in constrained directions.

    It is the error to the nearest pose that satisfies the target: in free
    directions the error is zero.

    Args:
        X_WE: Pose of the end effector, shape (4, 4).
        target: The `TargetArrays`.
    """
    p_ET_W, rotation_W, p_ET_E = error_arrays(X_WE, target.X_WT)
    if not has_free(target.weights):
        return p_ET_W, rotation_W, p_ET_E
    leave_free(target, p_ET_W)
    rotation_W = constrained_rotation(X_WE, target.X_WT, target.weights)
    for c in range(3):
        p_ET_E[c] = dot(X_WE[:3, c], p_ET_W)
    return p_ET_W, rotation_W, p_ET_E


@helper
def has_free(weights) -> bool:
    """Returns whether any direction is free (has the weight zero).

    Args:
        weights: Weights of the directions, shape (6,).
    """
    least = 1.0
    for weight in weights:
        least = min(least, weight)
    return least == 0.0


@helper
def leave_free(target, p_W) -> None:
    """Removes the free translations from a vector.

    Args:
        target: The `TargetArrays`.
        p_W: The vector in W, shape (3,).
    """
    for axis in range(3):
        if target.weights[3 + axis] != 0.0:
            continue
        along = dot(p_W, target.X_WT[:3, axis])
        for c in range(3):
            p_W[c] -= along * target.X_WT[c, axis]


@helper
def constrained_rotation(X_WE, X_WT, weights):
    """Computes the smallest rotation of E to its constrained orientation.

    If the rotation about one axis is free, the result is the smallest rotation
    that aligns this axis of E with that of T.

    Args:
        X_WE: Pose of the end effector, shape (4, 4).
        X_WT: Pose of the target, shape (4, 4).
        weights: Weights of the directions, shape (6,).

    Returns:
        Angle times axis in W, shape (3,) [rad].
    """
    count, free = 0, 0
    for axis in range(3):
        if weights[axis] == 0.0:
            count, free = count + 1, axis
    if count == 0:
        R_ET_W = np.zeros((3, 3))
        for r in range(3):
            for c in range(3):
                R_ET_W[r, c] = dot(X_WT[r], X_WE[c])
        return rotation_vector(R_ET_W)
    result = np.zeros(3)
    if count == 3:
        return result
    is_W, shall_W = X_WE[:3, free], X_WT[:3, free]
    normal = cross(is_W, shall_W)
    sine, cosine = math.sqrt(dot(normal, normal)), dot(is_W, shall_W)
    factor = 1.0
    if sine > 1e-9:
        factor = math.atan2(sine, cosine) / sine
    elif cosine < 0.0:  # Opposite: about any perpendicular axis.
        other = X_WE[:3, (free + 1) % 3]
        normal, factor = (other[0], other[1], other[2]), math.pi
    for c in range(3):
        result[c] = factor * normal[c]
    return result


@kernel(returns=several(reals(1), REAL, reals(1), reals(1), reals(1)))
def place_on_line(X_WE, target):
    """Finds the pose S on a target's line that is nearest to E.

    Args:
        X_WE: Pose of the end effector, shape (4, 4).
        target: The `TargetArrays`, with a line.

    Returns:
        The line's direction, shape (3,), its remaining length [m], the
        translation from E to S, shape (3,) [m], the rotation to S, shape (3,)
        [rad], and the line's rotation per metre, shape (3,) [rad/m]; all in W,
        with zeros in free directions.
    """
    along_W, turn_W, _ = constrained_error(target.X_WA, target)
    length = norm(along_W)
    if length < 1e-9:
        p_ET_W, rotation_W, _ = constrained_error(X_WE, target)
        return np.zeros(3), 0.0, p_ET_W, rotation_W, np.zeros(3)
    done = 0.0
    for c in range(3):
        along_W[c] /= length
        turn_W[c] /= length
        done += along_W[c] * (X_WE[c, 3] - target.X_WA[c, 3])
    done = min(max(done, 0.0), length)
    p_ES_W = np.empty(3)
    for c in range(3):
        start = target.X_WA[c, 3] - X_WE[c, 3]
        p_ES_W[c] = start + done * along_W[c]
    leave_free(target, p_ES_W)
    turned = _turned(target.X_WA, turn_W, done)
    rotation_W = constrained_rotation(X_WE, turned, target.weights)
    return along_W, length - done, p_ES_W, rotation_W, turn_W


@helper
def _turned(X, turn_W, done):
    """Returns X rotated by `done` times a rotation vector, at the origin."""
    angle = done * norm(turn_W)
    result = X.copy()
    if angle < 1e-12:
        return result
    axis = (turn_W[0], turn_W[1], turn_W[2])
    scale = done / angle
    R = rotation((axis[0] * scale, axis[1] * scale, axis[2] * scale), angle)
    for r in range(3):
        for c in range(3):
            result[r, c] = dot(R[r], X[:3, c])
    return result
