"""Effects of small errors of cameras on poses and on normal equations.

n views have 6 n + k unknowns: theta_W and t_W of one view after another, then
the k errors that all images share, see `camera_errors`. A view's true pose is

    R_WC = exp(theta_W) R_given,   p_WC = p_given + t_W.
"""

import numpy as np
from scipy.spatial.transform import Rotation

from remosplat_drake.base.kernels import numpy_kernel


def perturbed(X_WC: np.ndarray, error: np.ndarray) -> np.ndarray:
    """Applies small motions (n, 6) to the camera poses (n, 4, 4)."""
    result = X_WC.copy()
    turn = Rotation.from_rotvec(error[:, :3]).as_matrix()
    result[:, :3, :3] = turn @ X_WC[:, :3, :3]
    result[:, :3, 3] += error[:, 3:]
    return result


def difference(X_WC: np.ndarray, given: np.ndarray) -> np.ndarray:
    """Returns the motions (n, 6) from given camera poses to other poses."""
    turn = X_WC[:, :3, :3] @ given[:, :3, :3].transpose(0, 2, 1)
    theta = Rotation.from_matrix(turn).as_rotvec()
    return np.concatenate([theta, X_WC[:, :3, 3] - given[:, :3, 3]], axis=1)


def pair_expansion(
    X_WC: np.ndarray, pairs: np.ndarray, shared: int
) -> np.ndarray:
    """Returns matrices T that expand a pair's derivatives to both views.

    Args:
        X_WC: Poses, shape (n, 4, 4).
        pairs: Indices of views (a, b), shape (m, 2).
        shared: Number k of errors that all images share.

    Returns:
        The matrices T, shape (m, 12 + k, 6 + k). Let J_pair be the derivatives
        of a residual by theta_A, t_A and the shared errors. Then T J_pair are
        its derivatives by the unknowns of view a, those of view b, and the
        shared errors.
    """
    p_AB_W = X_WC[pairs[:, 1], :3, 3] - X_WC[pairs[:, 0], :3, 3]
    T = np.zeros((len(pairs), 12 + shared, 6 + shared))
    x, y, z = p_AB_W.T
    for i in range(3):
        T[:, i, i] = T[:, 3 + i, 3 + i] = 1
        T[:, 6 + i, i] = T[:, 9 + i, 3 + i] = -1
    T[:, 6, 4], T[:, 6, 5] = -z, y
    T[:, 7, 3], T[:, 7, 5] = z, -x
    T[:, 8, 3], T[:, 8, 4] = -y, x
    own = np.arange(shared)
    T[:, 12 + own, 6 + own] = 1
    return T


def assemble(
    H: np.ndarray, g: np.ndarray, X_WC: np.ndarray, pairs: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Sums the normal equations of pairs to those of all unknowns.

    Args:
        H: Matrices of the pairs, shape (m, 6 + k, 6 + k).
        g: Gradients of the pairs, shape (m, 6 + k).
        X_WC: Poses, shape (n, 4, 4).
        pairs: Indices of views (a, b), shape (m, 2).

    Returns:
        Matrix (6n + k, 6n + k) and gradient (6n + k,).
    """
    shared = g.shape[1] - 6
    T = pair_expansion(X_WC, pairs, shared)
    size = 6 * len(X_WC) + shared
    matrix, gradient = np.zeros((size, size)), np.zeros(size)
    large = T @ H @ T.transpose(0, 2, 1)
    _add(large, (T @ g[:, :, None])[:, :, 0], pairs, matrix, gradient)
    return matrix, gradient


@numpy_kernel
def _add(H, g, pairs, matrix, gradient):
    unknowns = g.shape[1]
    index = np.empty(unknowns, np.int64)
    for i in range(12, unknowns):
        index[i] = len(gradient) - unknowns + i
    for k in range(len(pairs)):
        for i in range(6):
            index[i] = 6 * pairs[k, 0] + i
            index[6 + i] = 6 * pairs[k, 1] + i
        for i in range(unknowns):
            gradient[index[i]] += g[k, i]
            for j in range(unknowns):
                matrix[index[i], index[j]] += H[k, i, j]
