"""Converts the quaternions and camera axes of poses in files."""

import numpy as np
from scipy.spatial.transform import Rotation

OPENGL_FROM_OPENCV = np.diag([1.0, -1.0, -1.0, 1.0])
"""Rotation from an OpenGL camera (looks along -z, y up) to an OpenCV camera.

X_WC = X_WC_gl @ OPENGL_FROM_OPENCV.
"""


def shortened(quaternions: np.ndarray) -> np.ndarray:
    """Scales finite quaternions (n, 4), so that their norms do not overflow.

    Raises:
        ValueError: A quaternion is zero.
    """
    length = np.abs(quaternions).max(axis=1, keepdims=True)
    if not length.all():
        raise ValueError("a quaternion is zero")
    return quaternions / length


def poses_from_quaternions(
    quaternions_xyzw: np.ndarray, translations: np.ndarray
) -> np.ndarray:
    """Makes poses, shape (n, 4, 4), from quaternions and translations.

    Poses of values that are not finite are not finite, either. A later check
    reports them.

    Args:
        quaternions_xyzw: Quaternions of any nonzero norm, shape (n, 4).
        translations: Translations, shape (n, 3) [m].

    Raises:
        ValueError: A quaternion is zero.
    """
    poses = np.tile(np.eye(4), (len(translations), 1, 1))
    finite = np.isfinite(quaternions_xyzw).all(axis=1)
    poses[~finite] = np.nan
    if finite.any():
        poses[finite, :3, :3] = Rotation.from_quat(
            shortened(quaternions_xyzw[finite])
        ).as_matrix()
    poses[:, :3, 3] = translations
    return poses
