"""Operations on planar poses (x, y, yaw), for example of a base."""

import numpy as np


def matrix(pose: np.ndarray) -> np.ndarray:
    """Returns the transforms (..., 4, 4) of poses of shape (..., 3)."""
    x, y, yaw = np.moveaxis(np.asarray(pose, float), -1, 0)
    X = np.zeros((*x.shape, 4, 4))
    X[..., 0, 0] = X[..., 1, 1] = np.cos(yaw)
    X[..., 1, 0] = np.sin(yaw)
    X[..., 0, 1] = -X[..., 1, 0]
    X[..., 0, 3], X[..., 1, 3] = x, y
    X[..., 2, 2] = X[..., 3, 3] = 1
    return X


def composed(X_AB: np.ndarray, X_BC: np.ndarray) -> np.ndarray:
    """Returns the pose X_AC from X_AB and X_BC, each of shape (3,)."""
    c, s = np.cos(X_AB[2]), np.sin(X_AB[2])
    x, y, yaw = X_BC
    return X_AB + np.array([c * x - s * y, s * x + c * y, yaw])


def relative(X_AB: np.ndarray, X_AC: np.ndarray) -> np.ndarray:
    """Returns X_BC from X_AB and X_AC, shape (3,), with yaw in [-pi, pi)."""
    c, s = np.cos(X_AB[2]), np.sin(X_AB[2])
    x, y, yaw = X_AC - X_AB
    yaw = (yaw + np.pi) % (2 * np.pi) - np.pi
    return np.array([c * x + s * y, -s * x + c * y, yaw])


def relative_jacobians(
    X_AB: np.ndarray, X_AC: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Returns the derivatives of `relative` by both poses, (3, 3) each."""
    c, s = np.cos(X_AB[2]), np.sin(X_AB[2])
    x, y, _ = relative(X_AB, X_AC)
    by_C = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1.0]])
    by_B = -by_C
    by_B[0, 2], by_B[1, 2] = y, -x
    return by_B, by_C


def odometry_frame(X_WB: np.ndarray, X_OB: np.ndarray) -> np.ndarray:
    """Returns the pose of odometry's frame O, X_WO = X_WB X_OB^-1, (3,)."""
    turn = np.array([0, 0, X_WB[2] - X_OB[2]])
    x, y, _ = X_WB - composed(turn, X_OB)
    return turn + np.array([x, y, 0])


def stepped(
    pose: np.ndarray, X_WB: np.ndarray, X_OB: np.ndarray, most: float
) -> np.ndarray:
    """Moves the pose X_WO of the odometry's frame by a limited step.

    A small turn of a distant frame O would move the base far, so the step of
    the base's pose in W is limited.

    Args:
        pose: The pose X_WO in effect, shape (3,) [m, rad].
        X_WB: Desired pose of the base, shape (3,) [m, rad].
        X_OB: The base's measured pose, shape (3,) [m, rad].
        most: Largest shift of the base [m], and largest turn [rad].
    """
    now = composed(pose, X_OB)
    turn = relative(now, X_WB)[2]
    shift = X_WB[:2] - now[:2]
    part = min(1.0, most / max(np.hypot(*shift), abs(turn), 1e-12))
    return odometry_frame(now + part * np.array([*shift, turn]), X_OB)


def largest_error(
    covariance: np.ndarray, sigmas: float, X_WB: np.ndarray, told: np.ndarray
) -> np.ndarray:
    """Bounds the distance of a reported pose from the true pose.

    Args:
        covariance: Covariance of the pose X_WB along W's axes, shape (3, 3).
        sigmas: Number of standard deviations in the bound.
        X_WB: Expected pose of the base, shape (3,) [m, rad].
        told: The reported pose, whose error is bounded, shape (3,) [m, rad].

    Returns:
        Distance and angle, shape (2,) [m, rad].
    """
    x, y, turn = relative(told, X_WB)
    spread = np.linalg.eigvalsh(covariance[:2, :2])[1], covariance[2, 2]
    return sigmas * np.sqrt(spread) + [np.hypot(x, y), abs(turn)]
