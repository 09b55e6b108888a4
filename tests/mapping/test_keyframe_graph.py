"""Constraints of tracked motions on keyframes, against difference quotients."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from remosplat_drake.mapping.localization.keyframe_graph import (
    motion_equations,
)
from remosplat_drake.robot.planar_pose import relative

POSES = st.lists(st.floats(-1, 1), min_size=9, max_size=9).map(
    lambda values: np.array(values).reshape(3, 3)
)


@settings(max_examples=30)
@given(POSES)
def test_motions_that_were_tracked_ask_for_nothing(poses):
    shift = np.array([2.0, -1.0, 0.0])
    covariance = np.tile(1e-4 * np.eye(3), (3, 1, 1))
    _, g = motion_equations(poses + shift, poses, covariance)
    np.testing.assert_allclose(g, 0, atol=1e-6)


@settings(max_examples=30)
@given(POSES, POSES)
def test_gradient_is_that_of_the_squared_error(X_WB, tracked):
    covariance = np.tile(np.diag([0.1, 0.1, 0.2]), (3, 1, 1))

    def cost(X: np.ndarray) -> float:
        total = 0.0
        for i in range(2):
            e = relative(X[i], X[i + 1]) - relative(tracked[i], tracked[i + 1])
            e[2] = (e[2] + np.pi) % (2 * np.pi) - np.pi
            # Alike in x and y, so that no turn of the axes matters.
            total += 0.5 * e @ np.diag([1 / 0.2, 1 / 0.2, 1 / 0.4]) @ e
        return total

    H, g = motion_equations(X_WB, tracked, covariance)
    assert np.linalg.eigvalsh(H).min() > -1e-9
    step = 1e-6
    for k in range(9):
        move = np.zeros(9)
        move[k] = step
        move = move.reshape(3, 3)
        slope = (cost(X_WB + move) - cost(X_WB - move)) / (2 * step)
        np.testing.assert_allclose(slope, g[k], atol=1e-3)
