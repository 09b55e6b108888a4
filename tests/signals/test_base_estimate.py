"""The drift of an odometry, worked by hand, and its derivatives."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from remosplat_drake.signals.base_estimate import (
    OTHER_RUN,
    BaseEstimate,
    Drift,
    moved,
    predicted,
)

STEADY = Drift(0.02, 0.002, memory=1e4)
POSES = st.tuples(*[st.floats(-1, 1)] * 3).map(np.array)


def test_a_steady_rate_carries_the_base_along():
    before = BaseEstimate(
        1.0, np.zeros(3), np.zeros(3), np.array([0.02, 0, 0.1]), np.eye(6)
    )
    after = predicted(before, np.array([1.0, 0, 0]), 3.0, STEADY)
    # Two seconds at 2 cm/s, besides the metre that odometry has measured.
    np.testing.assert_allclose(after.X_WB, [1.04, 0, 0.2], atol=1e-4)
    assert after.deviations[0] == pytest.approx(np.sqrt(1 + 2**2), rel=1e-3)


def test_odometry_moves_along_the_true_heading():
    before = BaseEstimate(
        0.0, np.zeros(3), np.array([0, 0, np.pi / 2]), np.zeros(3), np.eye(6)
    )
    after = predicted(before, np.array([1.0, 0, 0]), 0.1, STEADY)
    np.testing.assert_allclose(after.X_WB, [0, 1, np.pi / 2], atol=1e-9)


def test_noise_is_that_of_many_small_steps():
    drift, n = Drift(0.02, 0.002, memory=5.0), 4000
    step, P = 8.0 / n, np.zeros((2, 2))
    F = np.array([[1, step], [0, 1 - step / drift.memory]])
    for _ in range(n):
        P = F @ P @ F.T
        P[1, 1] += 2 * drift.shift**2 / drift.memory * step
    Q = drift.noise(8.0)
    np.testing.assert_allclose(Q[3, 0], P[0, 1], rtol=0.01)
    np.testing.assert_allclose(Q[3, 3], P[1, 1], rtol=0.01)
    np.testing.assert_allclose(Q[0, 0], P[0, 0], rtol=0.01)


def test_a_clock_that_starts_anew_is_another_run():
    first = BaseEstimate.first(100.0, np.zeros(3), STEADY)
    again = predicted(first, np.zeros(3), 0.0, STEADY)
    assert again.time == 0.0
    assert again.deviations[0] == pytest.approx(0.02 * OTHER_RUN, rel=0.01)


@settings(max_examples=30)
@given(POSES, POSES, POSES, POSES)
def test_jacobian_is_the_difference_quotient(b, v, o, o_after):
    drift, step = Drift(0.02, 0.002, memory=3.0), 1e-6
    _, F = moved(b, v, o, o_after, 2.0, drift)
    for k in range(6):
        ends = []
        for side in (1, -1):
            x = np.concatenate([b, v])
            x[k] += side * step
            ends.append(moved(x[:3], x[3:], o, o_after, 2.0, drift)[0])
        difference = (ends[0] - ends[1]) / (2 * step)
        np.testing.assert_allclose(difference, F[:, k], atol=1e-7)
