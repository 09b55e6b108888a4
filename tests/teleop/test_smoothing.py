"""Bounded speed and acceleration, exact arrival, and turns past half a turn."""

import numpy as np
import pytest
from effort import effort
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from pydrake.math import RollPitchYaw

from remosplat_drake.robot.pose_error import rotation_vector
from remosplat_drake.teleop.smoothing import (
    braking_speed,
    change_velocity,
    limit_norm,
    rotated,
    rotation_to_go,
    velocity_towards,
)

DT = 0.01
tries = settings(max_examples=effort(8, 25))
vectors = st.tuples(*[st.floats(-1, 1)] * 3).map(np.array)
angles = st.tuples(*[st.floats(-3, 3)] * 3)


def braking_distance(speed: float, acceleration: float) -> float:
    """Worked out step by step."""
    distance = 0.0
    while speed > 0:
        distance += speed * DT
        speed -= acceleration * DT
    return distance


def test_braking_speed_worked_by_hand():
    # Steps of 0.1 m/s each 0.1 s: 0.3, 0.2 and 0.1 m/s brake over 0.06 m.
    assert braking_speed(0.06, 1.0, 0.1) == pytest.approx(0.3)
    assert braking_speed(0.0, 1.0, 0.1) == 0.0
    # The last step ends on the goal itself.
    assert braking_speed(0.004, 1.0, 0.1) == pytest.approx(0.04)


@tries
@given(st.floats(0, 2), st.floats(0.1, 5))
def test_braking_ends_exactly_at_the_goal(distance, acceleration):
    speed = braking_speed(distance, acceleration, DT)
    assert braking_distance(speed, acceleration) == pytest.approx(
        distance, abs=1e-9
    )


@tries
@given(vectors, st.floats(0.05, 1), st.floats(0.2, 5))
def test_from_rest_it_arrives_on_a_straight_line(goal, max_speed, acceleration):
    p, v = np.zeros(3), np.zeros(3)
    length = np.linalg.norm(goal)
    assume(length > 1e-6)
    for _ in range(10_000):
        wanted = velocity_towards(goal - p, max_speed, acceleration, DT)
        before, v = v, change_velocity(v, wanted, acceleration * DT)
        p = p + v * DT
        assert np.linalg.norm(v) <= max_speed * (1 + 1e-9)
        assert np.linalg.norm(v - before) <= acceleration * DT * (1 + 1e-6)
        along = p @ goal / length
        assert along <= length + 1e-9
        assert np.linalg.norm(p - along * goal / length) < 1e-9
        if np.linalg.norm(goal - p) < 1e-9:
            break
    np.testing.assert_allclose(p, goal, atol=1e-9)


@tries
@given(vectors, vectors)
def test_it_arrives_however_it_moved_before(goal, v):
    p, v = np.zeros(3), limit_norm(v, 0.5)
    for _ in range(1500):
        wanted = velocity_towards(goal - p, 0.5, 1.0, DT)
        v = change_velocity(v, wanted, 1.0 * DT)
        p = p + v * DT
    np.testing.assert_allclose(p, goal, atol=1e-9)
    np.testing.assert_allclose(v, 0.0, atol=1e-9)


@tries
@given(angles, angles)
def test_a_turn_arrives_by_the_shorter_way(start, end):
    R = RollPitchYaw(start).ToRotationMatrix().matrix()
    goal = RollPitchYaw(end).ToRotationMatrix().matrix()
    w, turned = np.zeros(3), 0.0
    angle = np.linalg.norm(rotation_vector(goal @ R.T))
    for _ in range(400):
        offset = rotation_to_go(R, goal, w, 2.0)
        wanted = velocity_towards(offset, 1.0, 2.0, DT)
        before, w = w, change_velocity(w, wanted, 2.0 * DT)
        assert np.linalg.norm(w) <= 1.0 + 1e-9
        assert np.linalg.norm(w - before) <= 2.0 * DT * (1 + 1e-6)
        R = rotated(R, w * DT)
        turned += np.linalg.norm(w) * DT
    np.testing.assert_allclose(R, goal, atol=1e-7)
    assert turned == pytest.approx(angle, abs=1e-6)


def test_a_goal_that_trembles_at_half_a_turn_is_reached():
    """Its shorter way flips at each step; the turn goes on regardless."""
    R, w = np.eye(3), np.zeros(3)
    for i in range(500):
        goal = about_z(np.pi + (0.01 if i % 2 else -0.01))
        offset = rotation_to_go(R, goal, w, 2.0)
        wanted = velocity_towards(offset, 1.0, 2.0, DT)
        w = change_velocity(w, wanted, 2.0 * DT)
        R = rotated(R, w * DT)
    assert np.linalg.norm(rotation_vector(goal @ R.T)) < 0.03


def test_a_turn_goes_back_where_that_is_much_shorter():
    w = np.array([0.0, 0.0, 0.5])
    offset = rotation_to_go(about_z(0.0), about_z(-1.0), w, 2.0)
    np.testing.assert_allclose(offset, [0, 0, -1.0], atol=1e-12)


def test_a_turn_goes_on_past_the_far_side():
    w = np.array([0.0, 0.0, 0.5])
    offset = rotation_to_go(about_z(0.0), about_z(-3.1), w, 2.0)
    np.testing.assert_allclose(offset, [0, 0, 2 * np.pi - 3.1], atol=1e-9)


def test_turning_keeps_a_rotation_orthonormal():
    R = np.eye(3)
    for _ in range(2000):
        R = rotated(R, np.array([0.01, 0.02, -0.005]))
    np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-14)


def about_z(angle: float) -> np.ndarray:
    return rotated(np.eye(3), np.array([0.0, 0.0, angle]))
