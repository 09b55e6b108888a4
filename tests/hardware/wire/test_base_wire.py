"""The base's messages, and its pose between two of them."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from wire_messages import base_message

from remosplat_drake.hardware.wire.base import (
    base_axes,
    base_velocity,
    decode_base_status,
    encode_base_command,
    extrapolated_pose,
)
from remosplat_drake.hardware.wire.messages.base_command import base_command
from remosplat_drake.hardware.wire.messages.base_status import base_status
from remosplat_drake.hardware.wire.packets import BrokenMessage
from remosplat_drake.robot.kinematics import advance

T = 1_700_000_000.5
U = np.array([0.2, 0.1, -1.0])


def test_a_command_is_written():
    command = base_command.decode(encode_base_command(U, T))
    assert command.utime == 1_700_000_000_500_000
    assert (command.forward, command.left, command.yaw_rate) == (0.2, 0.1, -1)


@pytest.mark.parametrize(
    ("u", "velocity"),
    [([0.2, -1.0], [0.2, 0.0, -1.0]), ([0.2, 0.1, -1.0], [0.2, 0.1, -1.0])],
)
def test_commands_of_both_drives_are_velocities(u, velocity):
    assert base_velocity(np.array(u)).tolist() == velocity
    assert base_velocity(np.array(u))[base_axes(len(u))].tolist() == u


def test_without_a_base_nothing_is_commanded():
    assert base_axes(0) == []
    assert not base_velocity(np.zeros(0)).any()


def test_a_status_is_read():
    state = decode_base_status(base_message(protective_stop=1))
    np.testing.assert_array_equal(state.pose, [1.0, 2.0, 0.5])
    np.testing.assert_array_equal(state.velocity, [0.3, 0.05, -0.1])
    assert state.stamp == T
    assert state.mode == base_status.MOVING
    assert state.protective_stop and not state.emergency_stop
    assert state.battery == 0.5


@pytest.mark.parametrize(
    ("data", "problem"),
    [
        (base_message(pose=[0.0, np.nan, 0.0]), r"pose\[1\] is nan"),
        (base_message(yaw_rate=np.inf), r"velocity\[2\] is inf"),
        (base_message(mode=9), "mode is 9"),
        (base_message()[:20], "is not a whole base_status"),
        (base_command().encode(), "is not a whole base_status"),
    ],
)
def test_a_broken_status_is_named(data, problem):
    with pytest.raises(BrokenMessage, match=problem):
        decode_base_status(data)


def test_a_quarter_circle():
    """1 m of radius: from the origin along x, turning left, to (1, 1)."""
    pose = extrapolated_pose(np.zeros(3), np.array([1.0, 0, 1]), math.pi / 2)
    np.testing.assert_allclose(pose, [1, 1, math.pi / 2], atol=1e-15)


def test_straight_ahead_and_aside():
    pose = extrapolated_pose(
        np.array([1.0, 2.0, math.pi / 2]), np.array([0.5, 0.1, 0.0]), 0.1
    )
    np.testing.assert_allclose(pose, [0.99, 2.05, math.pi / 2], atol=1e-15)


@settings(max_examples=20)
@given(
    st.floats(-3, 3),
    st.tuples(st.floats(-0.5, 0.5), st.floats(-0.5, 0.5), st.floats(-2, 2)),
    st.floats(0, 0.3),
)
def test_two_halves_make_the_whole(yaw, velocity, duration):
    pose, velocity = np.array([0.1, -0.2, yaw]), np.array(velocity)
    half = extrapolated_pose(pose, velocity, duration / 2)
    np.testing.assert_allclose(
        extrapolated_pose(half, velocity, duration / 2),
        extrapolated_pose(pose, velocity, duration),
        atol=1e-15,
    )


@pytest.mark.parametrize("n_base", [2, 3])
def test_it_is_where_the_controller_expects_it(n_base):
    """The same arc as the robot model's own integration."""
    q, u = np.array([0.3, -0.1, 0.8]), np.array([0.4, -0.2, -0.7])
    u = u[base_axes(n_base)]
    np.testing.assert_allclose(
        extrapolated_pose(q, base_velocity(u), 0.1),
        advance(q, u, n_base, 0.1),
        atol=1e-12,
    )
