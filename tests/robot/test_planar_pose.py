"""Planar poses against Drake's transforms and finite differences."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from remosplat_drake.robot.planar_pose import (
    composed,
    matrix,
    odometry_frame,
    relative,
    relative_jacobians,
    stepped,
)

POSES = st.tuples(st.floats(-3, 3), st.floats(-3, 3), st.floats(-1.5, 1.5)).map(
    np.array
)


@given(POSES, POSES)
def test_agree_with_matrices(a, b):
    np.testing.assert_allclose(
        matrix(composed(a, b)), matrix(a) @ matrix(b), atol=1e-12
    )
    np.testing.assert_allclose(
        matrix(relative(a, b)), np.linalg.inv(matrix(a)) @ matrix(b), atol=1e-12
    )
    np.testing.assert_allclose(composed(odometry_frame(a, b), b), a, atol=1e-12)


@settings(max_examples=30)
@given(POSES, POSES)
def test_jacobians_are_the_difference_quotients(a, b):
    step = 1e-6
    for side, J in enumerate(relative_jacobians(a, b)):
        for k in range(3):
            moves = [np.zeros(3), np.zeros(3)]
            moves[side][k] = step
            more = relative(a + moves[0], b + moves[1])
            less = relative(a - moves[0], b - moves[1])
            turn = (more - less + np.pi) % (2 * np.pi) - np.pi
            np.testing.assert_allclose(turn / (2 * step), J[:, k], atol=1e-7)


@settings(max_examples=50)
@given(POSES, POSES, POSES)
def test_no_step_moves_the_base_by_more_than_allowed(pose, goal, X_OB):
    X_WB = composed(goal, X_OB)
    after = stepped(pose, X_WB, X_OB, 0.01)
    moved = relative(composed(pose, X_OB), composed(after, X_OB))
    assert np.hypot(*moved[:2]) <= 0.01 + 1e-9
    assert abs(moved[2]) <= 0.01 + 1e-9
    for _ in range(1000):
        after = stepped(after, X_WB, X_OB, 0.01)
    np.testing.assert_allclose(composed(after, X_OB), X_WB, atol=1e-9)
