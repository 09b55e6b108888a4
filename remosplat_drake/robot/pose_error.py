"""`PoseError`: translation and rotation from the end effector to its target."""

import dataclasses as dc
import math

import numpy as np


@dc.dataclass(frozen=True, eq=False)
class PoseError:
    """Pose error of the end effector E relative to its target T.

    Attributes:
        p_ET_W: Translation from E to T in W, shape (3,) [m].
        rotation_W: Rotation vector (angle times axis) from E to T in W, shape
            (3,) [rad].
        p_ET_E: Translation from E to T in E, shape (3,) [m]; its L1 norm scales
            the paper's costs.
    """

    p_ET_W: np.ndarray
    rotation_W: np.ndarray
    p_ET_E: np.ndarray

    @property
    def distance(self) -> float:
        """Euclidean distance from the end effector to the target [m]."""
        return math.hypot(*self.p_ET_W)

    @property
    def distance_l1(self) -> float:
        """L1 norm of the translation in E [m], as in the paper's costs."""
        return float(np.abs(self.p_ET_E).sum())

    @property
    def angle(self) -> float:
        """Angle of the rotation to the target [rad]."""
        return math.hypot(*self.rotation_W)


def pose_error(X_WE: np.ndarray, X_WT: np.ndarray) -> PoseError:
    """Computes the error from poses X_WE and X_WT, both of shape (4, 4)."""
    p_ET_W = X_WT[:3, 3] - X_WE[:3, 3]
    R_WE = X_WE[:3, :3]
    return PoseError(
        p_ET_W, rotation_vector(X_WT[:3, :3] @ R_WE.T), R_WE.T @ p_ET_W
    )


def rotation_vector(R: np.ndarray) -> np.ndarray:
    """Computes angle times axis of a rotation matrix, stable at 0 and at pi.

    Args:
        R: A rotation matrix, shape (3, 3).

    Returns:
        Shape (3,) [rad].
    """
    twice_sine_axis = np.array(
        [R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]
    )
    sine = 0.5 * math.hypot(*twice_sine_axis)
    cosine = 0.5 * (R[0, 0] + R[1, 1] + R[2, 2] - 1.0)
    angle = math.atan2(sine, cosine)
    if sine > 1e-6:
        return twice_sine_axis * (0.5 * angle / sine)
    if cosine > 0:
        return 0.5 * twice_sine_axis
    # Near pi the axis is the eigenvector of the symmetric part.
    symmetric = 0.5 * (R + R.T) + np.eye(3)
    axis = symmetric[:, np.argmax(np.diag(symmetric))]
    return angle * axis / np.linalg.norm(axis)
