"""Operations on arrays of unit quaternions wxyz."""

import numpy as np


def rotation_matrices(wxyz: np.ndarray) -> np.ndarray:
    """Converts unit quaternions wxyz, shape (N, 4), to matrices (N, 3, 3)."""
    w, x, y, z = wxyz.T
    R = np.empty((len(wxyz), 3, 3))
    R[:, 0, 0] = 1 - 2 * (y * y + z * z)
    R[:, 0, 1] = 2 * (x * y - w * z)
    R[:, 0, 2] = 2 * (x * z + w * y)
    R[:, 1, 0] = 2 * (x * y + w * z)
    R[:, 1, 1] = 1 - 2 * (x * x + z * z)
    R[:, 1, 2] = 2 * (y * z - w * x)
    R[:, 2, 0] = 2 * (x * z - w * y)
    R[:, 2, 1] = 2 * (y * z + w * x)
    R[:, 2, 2] = 1 - 2 * (x * x + y * y)
    return R


def quaternion_product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Computes the products a b of a quaternion a (4,) and b (N, 4), wxyz."""
    aw, ax, ay, az = a
    bw, bx, by, bz = b.T
    return np.stack(
        [
            aw * bw - ax * bx - ay * by - az * bz,
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
        ],
        axis=1,
    )
