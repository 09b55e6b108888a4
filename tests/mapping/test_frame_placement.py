"""Directions in which surfaces hold a base, and the covariance afterwards."""

import numpy as np
import pytest

from remosplat_drake.mapping.localization.frame_placement import (
    updated,
    without_slips,
)
from remosplat_drake.signals.base_estimate import BaseEstimate, Drift


def walls(*normals: tuple[float, float, float]) -> np.ndarray:
    """Information of points whose residuals have given derivatives."""
    return sum(1e4 * np.outer(n, n) for n in normals)


def test_two_walls_hold_a_base():
    H = walls((1, 0, 0.3), (0, 1, -0.2), (1, 0, -0.5))
    g = np.array([1.0, 2.0, 3.0])
    kept, pull = without_slips(H, g)
    np.testing.assert_array_equal(kept, H)
    np.testing.assert_array_equal(pull, g)


def test_along_one_wall_it_slides():
    # The wall's normal is x; noise pretends to know a little of y.
    H = walls((1, 0, 0.3), (1, 0, -0.5), (0.0, 0.02, 0.0))
    g = np.array([1.0, 2.0, 3.0])
    kept, pull = without_slips(H, g)
    np.testing.assert_allclose(kept[1], 0, atol=1e-9)
    np.testing.assert_allclose(pull, [1, 0, 3], atol=1e-6)
    np.testing.assert_allclose(kept[[0, 2]][:, [0, 2]], H[[0, 2]][:, [0, 2]])


def test_what_keyframes_err_by_is_not_averaged_away():
    estimate = BaseEstimate.first(0.0, np.zeros(3), Drift(0.02, 0.002))
    P = np.diag([1e-4] * 3 + [4e-4] * 3)
    theirs = np.diag([1e-5] * 3)
    for _ in range(50):
        estimate = BaseEstimate(0.0, np.zeros(3), np.zeros(3), np.zeros(3), P)
        P = updated(estimate, np.zeros(3), 1e9 * np.eye(3), theirs).covariance
    assert P[0, 0] == pytest.approx(1e-5, rel=0.01)


def test_a_rate_follows_from_where_the_base_was_found():
    # The position's error comes from one second of an unknown rate.
    P = np.kron([[4e-4, 4e-4], [4e-4, 4e-4 + 1e-12]], np.eye(3))
    P[:3, :3] += 1e-10 * np.eye(3)
    expected = BaseEstimate(1.0, np.zeros(3), np.zeros(3), np.zeros(3), P)
    found = np.array([0.012, -0.016, 0])
    after = updated(expected, found, 1e12 * np.eye(3), np.zeros((3, 3)))
    np.testing.assert_allclose(after.rate, found, atol=1e-5)
