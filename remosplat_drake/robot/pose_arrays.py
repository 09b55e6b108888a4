"""Operations on arrays of poses."""

import numpy as np


def inverse_poses(X: np.ndarray) -> np.ndarray:
    """Inverts poses.

    Args:
        X: The poses, shape (n, 4, 4).
    """
    R = np.swapaxes(X[:, :3, :3], 1, 2)
    inverse = np.zeros_like(X)
    inverse[:, :3, :3] = R
    inverse[:, :3, 3] = -(R @ X[:, :3, 3, None])[:, :, 0]
    inverse[:, 3, 3] = 1.0
    return inverse
