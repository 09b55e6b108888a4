"""Computes the poses of a scan, from which a wrist camera looks around."""

import numpy as np
from pydrake.math import RotationMatrix

from remosplat_drake.teleop.teleop_config import ScanConfig


def scan_poses(
    X_WE: np.ndarray, X_EC: np.ndarray, count: int, config: ScanConfig
) -> tuple[np.ndarray, ...]:
    """Computes poses of the end effector that turn a camera on the spot.

    The camera's position does not change, and its image remains upright. The
    camera looks ahead and down. Its views form a row of steep views, and then,
    in the opposite direction, a row of flatter views, so that consecutive views
    are near each other. With up to three poses, there is only one row, at the
    mean pitch of the two rows.

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
    """Returns the yaw in W of a camera's horizontal viewing direction [rad].

    For a camera that looks straight down, it is the yaw of the image's upward
    direction.
    """
    forward, up = R_WC[:, 2], -R_WC[:, 1]
    return float(np.arctan2(forward[1] + up[1], forward[0] + up[0]))


def upright_camera(yaw: float, pitch: float) -> np.ndarray:
    """Returns R_WC, shape (3, 3), of a camera whose image is upright.

    Args:
        yaw: Yaw of the viewing direction in W [rad].
        pitch: Angle of the viewing direction below the horizon [rad].
    """
    R_WL = RotationMatrix.MakeZRotation(yaw).matrix()
    s, c = np.sin(pitch), np.cos(pitch)
    # The columns are the camera's axes in a frame L, whose x axis points ahead.
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
    """Returns n pan angles from left to right; a single angle is 0."""
    return np.linspace(bound, -bound, n) if n > 1 else np.zeros(1)
