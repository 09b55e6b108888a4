"""The drivers' rules for commands: expiry, strictness, maxima."""

import math

import numpy as np
import pytest
from drake import lcmt_panda_command
from hypothesis import given, settings
from hypothesis import strategies as st

from remosplat_drake.hardware.drivers.base_commands import (
    BaseCommands,
    BaseMaxima,
    clamped,
)
from remosplat_drake.hardware.drivers.panda_commands import (
    ArmCommands,
)
from remosplat_drake.hardware.wire.messages.base_command import base_command

NOW = 1_700_000_000_000_000
EXPIRY = 100_000  # [us]


def arm_message(utime: int = NOW, **fields) -> bytes:
    message = lcmt_panda_command()
    message.utime = utime
    message.control_mode_expected = 2
    message.joint_velocity = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7]
    for name, value in fields.items():
        setattr(message, name, value)
    message.num_joint_velocity = len(message.joint_velocity)
    message.num_joint_position = len(message.joint_position)
    message.num_joint_torque = len(message.joint_torque)
    return message.encode()


def base_message(utime: int = NOW, forward=0.5, yaw_rate=0.2) -> bytes:
    message = base_command()
    message.utime, message.forward, message.yaw_rate = utime, forward, yaw_rate
    return message.encode()


# The arm


def test_before_the_first_command_the_arm_stands():
    assert not ArmCommands().velocity(NOW).any()


@pytest.mark.parametrize("age", [-EXPIRY, 0, EXPIRY])
def test_a_command_counts_within_its_expiry_either_way(age):
    commands = ArmCommands()
    commands.receive(arm_message(NOW - age))
    np.testing.assert_allclose(commands.velocity(NOW)[:2], [0.1, 0.2])


@pytest.mark.parametrize("age", [-EXPIRY - 1, EXPIRY + 1])
def test_an_old_or_future_command_is_dropped_for_good(age):
    commands = ArmCommands()
    commands.receive(arm_message(NOW - age))
    assert not commands.velocity(NOW).any()
    assert not commands.velocity(NOW - age).any()
    assert commands.expired == 1


def test_a_fresh_command_after_an_expired_one_counts():
    commands = ArmCommands()
    commands.receive(arm_message(NOW - 2 * EXPIRY))
    commands.velocity(NOW)
    commands.receive(arm_message(NOW))
    assert commands.velocity(NOW).any()


@pytest.mark.parametrize(
    ("fields", "mention"),
    [
        ({"control_mode_expected": 1}, "control_mode_expected"),
        ({"control_mode_expected": 6}, "control_mode_expected"),
        ({"joint_velocity": [0.0] * 6}, "num_joint_velocity"),
        ({"joint_position": [0.0] * 7}, "num_joint_position"),
        ({"joint_torque": [0.0] * 7}, "num_joint_torque"),
        ({"joint_velocity": [math.nan] * 7}, "not finite"),
    ],
)
def test_what_is_no_velocity_command_is_counted_and_named(fields, mention):
    commands = ArmCommands()
    commands.receive(arm_message(**fields))
    assert (commands.received, commands.broken) == (0, 1)
    assert mention in commands.complaint
    assert not commands.velocity(NOW).any()


def test_a_stray_packet_ends_neither_the_driver_nor_a_motion():
    commands = ArmCommands()
    commands.receive(arm_message())
    for data in (b"", b"nonsense", bytes(40), arm_message()[:-3]):
        commands.receive(data)
        assert "message" in commands.complaint
    assert commands.broken == 4
    assert commands.velocity(NOW)[0] == pytest.approx(0.1)


# The base


@pytest.mark.parametrize(
    ("asked", "done"),
    [
        ((0.5, 0.4), (0.5, 0.4)),
        ((2.0, 0.4), (1.0, 0.2)),
        ((-0.5, 0.4), (-0.25, 0.2)),
        ((0.5, 1.744), (0.25, 0.872)),
        ((math.nan, 0.1), (0.0, 0.0)),
        ((0.1, math.inf), (0.0, 0.0)),
    ],
)
def test_a_base_command_is_scaled_to_the_maxima(asked, done):
    assert clamped(*asked, BaseMaxima()) == pytest.approx(done)


def test_a_clamped_turn_is_one_that_the_robots_node_accepts():
    # qcr/ros_omron_agv rejects what exceeds its 50 degrees a second.
    _, yaw_rate = clamped(0.0, 3.0, BaseMaxima())
    assert 0.8 < yaw_rate < math.radians(50)


@settings(max_examples=100)
@given(st.floats(), st.floats())
def test_no_command_exceeds_the_maxima(forward, yaw_rate):
    v, omega = clamped(forward, yaw_rate, BaseMaxima())
    assert -0.25 <= v <= 1.0
    assert abs(omega) <= 0.872
    if math.isfinite(forward) and math.isfinite(yaw_rate):
        assert v * forward >= 0
        assert omega * yaw_rate >= 0


@pytest.mark.parametrize("direction", [-1, 1])
def test_a_base_command_counts_until_it_expires(direction):
    commands = BaseCommands()
    commands.receive(base_message(), 5.0)
    edge = NOW + direction * EXPIRY
    assert commands.velocity(NOW, 5.0) == (0.5, 0.2)
    assert commands.velocity(edge, 5.1) == (0.5, 0.2)
    assert commands.velocity(edge + direction, 5.1) == (0.0, 0.0)
    assert commands.velocity(NOW, 5.1) == (0.0, 0.0)


def test_silence_stops_the_base_whatever_the_clock_says():
    commands = BaseCommands()
    commands.receive(base_message(), 5.0)
    assert commands.velocity(NOW, 5.199) == (0.5, 0.2)
    assert commands.velocity(NOW, 5.201) == (0.0, 0.0)


def test_bytes_that_are_no_base_command_are_ignored():
    commands = BaseCommands()
    for data in (b"", b"nonsense", base_message()[:-3]):
        commands.receive(data, 0.0)
    assert commands.received == 0
    assert commands.velocity(NOW, 0.0) == (0.0, 0.0)
