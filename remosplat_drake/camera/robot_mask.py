"""Masks the robot in its own depth images.

A robot's camera sees the robot's own arm and fingers. If a map contained these
as obstacles, the robot would be blocked permanently. The robot's spheres cover
it, so a measured point in or behind a sphere may belong to the robot.
"""

import numpy as np

from remosplat_drake.robot.sphere_model import Spheres


def robot_mask(
    spheres: Spheres,
    K: np.ndarray,
    X_WC: np.ndarray,
    depth: np.ndarray,
    margin: float = 0.02,
) -> np.ndarray:
    """Finds the pixels that may show the robot.

    A pixel with a depth z is hidden if its ray enters an inflated sphere at a
    depth of z + `margin` or less. A pixel without a depth is hidden if its ray
    meets an inflated sphere anywhere. A sphere that contains the camera masks
    only points inside it, and pixels without depth.

    Args:
        spheres: The robot's spheres in W, which must cover all of it.
        K: Intrinsic matrix, shape (3, 3) [pixels]; see `Capture`.
        X_WC: Camera pose (OpenCV axes), shape (4, 4).
        depth: Depth z in C, shape (h, w) [m]; 0 where it is unknown.
        margin: Distance by which spheres are inflated, and by which a measured
            point may be in front of the robot [m]: the sum of the errors of
            kinematics, calibration and depth.

    Returns:
        A mask of shape (h, w), True where a pixel may show the robot.
    """
    height, width = depth.shape
    x = (np.arange(width) + 0.5 - K[0, 2]) / K[0, 0]
    y = (np.arange(height) + 0.5 - K[1, 2]) / K[1, 1]
    # The ray of a pixel is t (x, y, 1): its parameter is the depth z.
    square = x**2 + y[:, None] ** 2 + 1
    reach = np.where(depth > 0, depth + margin, np.inf)
    p_CS = (spheres.p_WS - X_WC[:3, 3]) @ X_WC[:3, :3]
    radii = spheres.radius + margin
    hidden = np.zeros(depth.shape, bool)
    for (sx, sy, sz), radius in zip(p_CS, radii, strict=True):
        # Where |t (x, y, 1) - p_CS| = radius: a quadratic equation in t.
        middle = sx * x + sy * y[:, None] + sz
        offset = sx**2 + sy**2 + sz**2 - radius**2
        discriminant = middle**2 - square * offset
        root = np.sqrt(np.maximum(discriminant, 0))
        if offset > 0:
            entry = (middle - root) / square
            hidden |= (discriminant >= 0) & (middle > 0) & (entry <= reach)
        else:
            leaves = (middle + root) / square
            hidden |= (depth <= leaves) | (depth == 0)
    return hidden
