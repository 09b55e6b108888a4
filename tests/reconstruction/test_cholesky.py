"""Factors of matrices that rounding has made indefinite."""

import numpy as np
import pytest
from scipy.linalg import LinAlgError

from remosplat_drake.reconstruction.alignment.cholesky import lower_factor


def test_a_sound_matrix_is_factorised_exactly():
    rng = np.random.default_rng(0)
    root = rng.standard_normal((8, 8))
    H = root @ root.T
    L = lower_factor(H)
    np.testing.assert_allclose(L @ L.T, H, rtol=1e-12, atol=1e-12)
    assert (np.triu(L, 1) == 0).all()


def test_rounding_is_forgiven_and_scales_do_not_matter():
    """A sum of squares of rank 3 with entries from 1e-6 to 1e14."""
    rng = np.random.default_rng(1)
    size = 10.0 ** np.linspace(-3, 7, 30)
    root = rng.standard_normal((30, 3))
    H = (root @ root.T) * np.outer(size, size)
    H = (H + H.T) / 2
    with pytest.raises(LinAlgError):
        np.linalg.cholesky(H - 1e-15 * np.diag(np.diag(H)))
    L = lower_factor(H)
    error = np.abs(L @ L.T - H) / np.outer(*2 * [np.sqrt(np.diag(H))])
    assert error.max() < 1e-9


def test_what_is_really_indefinite_is_refused():
    with pytest.raises(LinAlgError):
        lower_factor(np.array([[1.0, 2.0], [2.0, 1.0]]))
