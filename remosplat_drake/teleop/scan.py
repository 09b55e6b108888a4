"""The poses of a scan, from which a wrist camera looks around."""

import numpy as np
from pydrake.math import RotationMatrix

from remosplat_drake.teleop.teleop_config import ScanConfig


def scan_poses(
    X_WE: np.ndarray, X_EC: np.ndarray, count: int, config: ScanConfig
) -> tuple[np.ndarray, ...]:
    """Computes poses of the end effector that turn a camera in its place.

    The camera stays where it is and looks ahead and down, its image upright:
    along a row of steep views first and back along a row of flatter ones, so
    that neighbours are near. Up to three poses lie in one row, half as steep
    as both.

    Args:
        X_WE: Pose of the end effector where the scan begins, shape (4, 4).
        X_EC: Pose of the camera (OpenCV axes) in the end effector's frame,
            shape (4, 4).
        count: Number of poses, at least one.
        config: The directions in which the camera looks.

    Returns:
        Poses X_WE of the end effector, shape (4, 4) each.
    """
    X_WC = X_WE @ X_EC
    ahead = heading(X_WC[:3, :3])
    X_CE = np.linalg.inv(X_EC)
    poses = []
    for pan, pitch in np.radians(_directions(count, config)):
        X_WV = X_WC.copy()
        X_WV[:3, :3] = upright_camera(ahead + pan, pitch)
        poses.append(X_WV @ X_CE)
    return tuple(poses)


def heading(R_WC: np.ndarray) -> float:
    """Returns where a camera looks in the horizontal plane, a yaw in W [rad].

    For one that looks straight down it is where the top of its image is.
    """
    forward, up = R_WC[:, 2], -R_WC[:, 1]
    return float(np.arctan2(forward[1] + up[1], forward[0] + up[0]))


def upright_camera(yaw: float, pitch: float) -> np.ndarray:
    """Returns R_WC, shape (3, 3), of a camera whose image is upright.

    Args:
        yaw: Where it looks in the horizontal plane [rad].
        pitch: How far it looks down below the horizon [rad].
    """
    R_WL = RotationMatrix.MakeZRotation(yaw).matrix()
    s, c = np.sin(pitch), np.cos(pitch)
    # Columns are the camera's axes in L, whose x axis is ahead.
    R_LC = np.array([[0.0, -s, c], [-1.0, 0.0, 0.0], [0.0, -c, -s]])
    return R_WL @ R_LC


def _directions(count: int, config: ScanConfig) -> list[tuple[float, float]]:
    """Pan and pitch [deg] of each view."""
    steep, flat = config.steep_deg, config.flat_deg
    if count <= 3:
        row = _spread(count, config.pan_deg)
        return [(pan, 0.5 * (steep + flat)) for pan in row]
    first = 2 * count // 5  # Steep views overlap more.
    return [
        *((pan, steep) for pan in _spread(first, config.pan_deg)),
        *((-pan, flat) for pan in _spread(count - first, config.pan_deg)),
    ]


def _spread(n: int, bound: float) -> np.ndarray:
    """Returns n pan angles from left to right; a single one is 0."""
    return np.linspace(bound, -bound, n) if n > 1 else np.zeros(1)
