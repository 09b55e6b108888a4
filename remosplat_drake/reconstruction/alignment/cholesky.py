"""Cholesky factors of matrices that are positive definite up to rounding."""

import numpy as np
from scipy.linalg import LinAlgError, cholesky

_JITTER = (0.0, 1e-14, 1e-12, 1e-10, 1e-8)
"""The matrix is scaled so that its diagonal consists of ones. These values are
tried in turn: a value is added to the diagonal, until the matrix can be
factorised. Captures with exact depths need a value above 0, since they
determine some directions 1e15 times as well as others.
"""


def lower_factor(H: np.ndarray) -> np.ndarray:
    """Computes L with H = L L^T, L lower triangular.

    Args:
        H: Symmetric matrix with a positive diagonal, shape (n, n).

    Raises:
        LinAlgError: The matrix has a negative eigenvalue that rounding does not
            explain.
    """
    size = np.sqrt(np.diag(H))
    scaled = H / np.outer(size, size)
    for jitter in _JITTER:
        try:
            jittered = scaled + jitter * np.eye(len(H))
            factor = cholesky(jittered, lower=True, check_finite=False)
            return size[:, None] * factor
        except LinAlgError:
            if jitter == _JITTER[-1]:
                raise
    raise AssertionError("unreachable")
