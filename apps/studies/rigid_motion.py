"""Rigid motions between frames, and errors of poses."""

import dataclasses as dc

import numpy as np
from scipy.spatial.transform import Rotation


@dc.dataclass(frozen=True)
class CameraErrors:
    """Errors of poses and scale.

    Attributes:
        position: Largest error of a camera's position in W [m].
        shape: Largest error of a camera's position after the best rigid motion
            [m], which no other choice of W reduces.
        rotation: Largest error of a camera's rotation in W [rad].
        scale: Error of the depth's scale.
    """

    position: float
    shape: float
    rotation: float
    scale: float


def camera_errors(
    X_WC: np.ndarray, true_X_WC: np.ndarray, scale: float
) -> CameraErrors:
    """Compares poses with the true ones.

    Args:
        X_WC: Poses, shape (n, 4, 4).
        true_X_WC: The true poses, shape (n, 4, 4).
        scale: Ratio of measured to true depths.
    """
    p_W, true_W = X_WC[:, :3, 3], true_X_WC[:, :3, 3]
    R = X_WC[:, :3, :3] @ true_X_WC[:, :3, :3].transpose(0, 2, 1)
    fitted_W = transformed(rigid_fit(p_W, true_W), p_W)
    return CameraErrors(
        position=float(np.linalg.norm(p_W - true_W, axis=1).max()),
        shape=float(np.linalg.norm(fitted_W - true_W, axis=1).max()),
        rotation=float(Rotation.from_matrix(R).magnitude().max()),
        scale=scale - 1,
    )


def rigid_fit(p_A: np.ndarray, p_B: np.ndarray) -> np.ndarray:
    """Finds the pose X_BA that brings points closest to others.

    Args:
        p_A: Points in A, shape (n, 3) [m].
        p_B: The same points in B, shape (n, 3) [m].

    Returns:
        Shape (4, 4).
    """
    middle_A, middle_B = p_A.mean(axis=0), p_B.mean(axis=0)
    X_BA = np.eye(4)
    R_BA = Rotation.align_vectors(p_B - middle_B, p_A - middle_A)[0]
    X_BA[:3, :3] = R_BA.as_matrix()
    X_BA[:3, 3] = middle_B - R_BA.apply(middle_A)
    return X_BA


def transformed(X_BA: np.ndarray, p_A: np.ndarray) -> np.ndarray:
    """Returns points (n, 3) of A in B, given the pose of A in B (4, 4)."""
    return p_A @ X_BA[:3, :3].T + X_BA[:3, 3]
