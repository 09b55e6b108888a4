"""`PoseError`: translation and rotation from the end effector to its target."""

import dataclasses as dc
import math

import numpy as np

from remosplat_drake.base.kernels import kernel


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
    return PoseError(
        *error_arrays(np.array(X_WE, order="C"), np.array(X_WT, order="C"))
    )


@kernel
def error_arrays(X_WE, X_WT):
    """Computes the attributes of a `PoseError`, as a tuple.

    Args:
        X_WE: Pose of the end effector, shape (4, 4).
        X_WT: Pose of the target, shape (4, 4).
    """
    p_ET_W, p_ET_E = np.empty(3), np.zeros(3)
    R_ET_W = np.zeros((3, 3))
    for r in range(3):
        p_ET_W[r] = X_WT[r, 3] - X_WE[r, 3]
    for r in range(3):
        for c in range(3):
            p_ET_E[r] += X_WE[c, r] * p_ET_W[c]
            for k in range(3):
                R_ET_W[r, c] += X_WT[r, k] * X_WE[c, k]
    return p_ET_W, rotation_vector(R_ET_W), p_ET_E


@kernel(linked=True)
def rotation_vector(R):
    """Computes angle times axis of a rotation matrix, stable at 0 and at pi.

    Args:
        R: A rotation matrix, shape (3, 3).

    Returns:
        Shape (3,) [rad].
    """
    vector = np.empty(3)
    for k in range(3):
        vector[k] = R[(k + 2) % 3, (k + 1) % 3] - R[(k + 1) % 3, (k + 2) % 3]
    sine = 0.5 * math.sqrt(np.sum(vector * vector))
    cosine = 0.5 * (R[0, 0] + R[1, 1] + R[2, 2] - 1.0)
    angle = math.atan2(sine, cosine)
    if sine > 1e-6:
        return vector * (0.5 * angle / sine)
    if cosine > 0:
        return 0.5 * vector
    # Near pi the axis is the eigenvector of the symmetric part.
    longest = 0
    for k in range(1, 3):
        if R[k, k] > R[longest, longest]:
            longest = k
    for k in range(3):
        vector[k] = 0.5 * (R[k, longest] + R[longest, k])
    vector[longest] += 1.0
    return angle * vector / math.sqrt(np.sum(vector * vector))
