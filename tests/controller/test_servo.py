"""Pose errors and the twist that the servo wants."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.common.eigen_geometry import AngleAxis

from remosplat_drake.controller.program.servo import servo_twist
from remosplat_drake.robot.pose_error import (
    PoseError,
    pose_error,
    rotation_vector,
)


def rotation(angle: float, axis) -> np.ndarray:
    axis = np.array(axis, float) / np.linalg.norm(axis)
    return AngleAxis(angle, axis).rotation()


def test_no_rotation_is_the_zero_vector():
    np.testing.assert_array_equal(rotation_vector(np.eye(3)), np.zeros(3))


@pytest.mark.parametrize("angle", [1e-12, 1e-8, 1e-6, 2e-6, 1e-3])
def test_a_small_rotation_keeps_its_digits(angle):
    axis = np.array([2.0, -1.0, 2.0]) / 3
    np.testing.assert_allclose(
        rotation_vector(rotation(angle, axis)), angle * axis, atol=1e-15
    )


@given(
    angle=st.floats(1e-6, np.pi - 1e-5),
    axis=st.tuples(*[st.floats(-1, 1)] * 3).filter(
        lambda a: np.linalg.norm(a) > 0.1
    ),
)
@settings(max_examples=60)
def test_the_vector_is_angle_times_axis(angle, axis):
    unit = np.array(axis) / np.linalg.norm(axis)
    np.testing.assert_allclose(
        rotation_vector(rotation(angle, axis)), angle * unit, atol=1e-9
    )


@pytest.mark.parametrize("short_of_pi", [0.0, 1e-9, 1e-7, 1e-5])
@pytest.mark.parametrize(
    "axis", [(1, 0, 0), (0, -1, 0), (0, 0, 1), (1, -2, 3), (-1, 1e-8, 0)]
)
def test_half_a_turn_has_an_axis(axis, short_of_pi):
    R = rotation(np.pi - short_of_pi, axis)
    vector = rotation_vector(R)
    angle = np.linalg.norm(vector)
    assert angle == pytest.approx(np.pi - short_of_pi, abs=1e-9)
    # At half a turn axis and -axis are the same rotation.
    np.testing.assert_allclose(rotation(angle, vector), R, atol=3e-6)


def test_the_error_is_expressed_in_the_world_and_in_the_end_effector():
    X_WE, X_WT = np.eye(4), np.eye(4)
    X_WE[:3, :3] = rotation(np.pi / 2, (0, 0, 1))
    X_WE[:3, 3] = (1, 1, 0)
    X_WT[:3, 3] = (4, 1, -4)
    error = pose_error(X_WE, X_WT)
    np.testing.assert_allclose(error.p_ET_W, (3, 0, -4))
    # E's x axis is W's y axis, and its y axis is W's -x axis.
    np.testing.assert_allclose(error.p_ET_E, (0, -3, -4), atol=1e-15)
    np.testing.assert_allclose(error.rotation_W, (0, 0, -np.pi / 2))
    assert error.distance == pytest.approx(5)
    assert error.distance_l1 == pytest.approx(7)
    assert error.angle == pytest.approx(np.pi / 2)


def test_the_rotation_carries_the_end_effector_to_the_target():
    X_WE, X_WT = np.eye(4), np.eye(4)
    X_WE[:3, :3] = rotation(0.7, (1, 2, 3))
    X_WT[:3, :3] = rotation(-1.1, (0, 1, -1))
    vector = pose_error(X_WE, X_WT).rotation_W
    R = rotation(np.linalg.norm(vector), vector)
    np.testing.assert_allclose(R @ X_WE[:3, :3], X_WT[:3, :3], atol=1e-12)


def test_a_slow_twist_is_proportional():
    error = PoseError(np.array([0.1, 0, 0]), np.array([0, 0.2, 0]), np.ones(3))
    w, v = servo_twist(error, gain=2.0, max_speed=0.5)
    np.testing.assert_allclose(w, (0, 0.4, 0))
    np.testing.assert_allclose(v, (0.2, 0, 0))


def test_a_fast_twist_is_scaled_as_a_whole():
    error = PoseError(np.array([3.0, 0, -4]), np.array([0, 2.0, 0]), np.ones(3))
    w, v = servo_twist(error, gain=1.0, max_speed=0.5)
    np.testing.assert_allclose(v, (0.3, 0, -0.4))
    np.testing.assert_allclose(w, (0, 0.2, 0))


def test_no_error_wants_no_motion():
    error = PoseError(np.zeros(3), np.zeros(3), np.zeros(3))
    w, v = servo_twist(error, gain=4.0, max_speed=0.5)
    np.testing.assert_array_equal([*w, *v], np.zeros(6))
