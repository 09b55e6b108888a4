"""Views straight down onto a plane."""

import numpy as np

from remosplat_drake.capture.capture import Capture

FOCAL, SIZE = 100.0, 80


def looking_down(p_WC: np.ndarray) -> Capture:
    """Views from points p_WC (n, 3) straight down onto the plane z = 0."""
    count = len(p_WC)
    X_WC = np.tile(np.diag([1.0, -1.0, -1.0, 1.0]), (count, 1, 1))
    X_WC[:, :3, 3] = p_WC
    K = np.array([[FOCAL, 0, SIZE / 2], [0, FOCAL, SIZE / 2], [0, 0, 1]])
    depth = np.ones((count, SIZE, SIZE), np.float32)
    depth *= p_WC[:, 2, None, None].astype(np.float32)
    return Capture(
        np.tile(K, (count, 1, 1)),
        X_WC,
        np.zeros((count, SIZE, SIZE, 3), np.uint8),
        depth,
    )
