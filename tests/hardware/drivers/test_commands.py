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
from remosplat_drake.hardware.wire.base import base_velocity
from remosplat_drake.hardware.wire.channels import (
    BASE_COMMAND,
    COMMAND_RAMP,
    PANDA_COMMAND,
)
from remosplat_drake.hardware.wire.messages.base_command import base_command
from remosplat_drake.hardware.wire.ramp import encode_ramp

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


def ramp_message(utime: int = NOW, period=0.01, length=0.04) -> bytes:
    """A ramp of four steps."""
    return encode_ramp(utime * 1e-6, period, length)


def test_a_ramp_leads_the_arm_to_rest():
    commands = ArmCommands()
    commands.hear(COMMAND_RAMP, ramp_message())
    commands.hear(PANDA_COMMAND, arm_message())
    for age, share in (
        (0, 1.0),
        (14_900, 1.0),
        (15_100, 0.75),
        (25_100, 0.5),
        (45_100, 0.0),
    ):
        velocity = commands.velocity(NOW + age)
        assert velocity[0] == pytest.approx(0.1 * share)
    assert commands.expired == 1


def test_a_long_ramp_goes_on_where_a_command_would_expire():
    commands = ArmCommands()
    commands.hear(COMMAND_RAMP, ramp_message(length=1.0))
    commands.hear(PANDA_COMMAND, arm_message())
    assert commands.velocity(NOW)[0] == pytest.approx(0.1)
    later = commands.velocity(NOW + 3 * EXPIRY)
    assert later[0] == pytest.approx(0.1 * (1 - 0.29))


@pytest.mark.parametrize("age", [-EXPIRY - 1, EXPIRY + 1])
def test_what_comes_late_has_no_ramp(age):
    commands = ArmCommands()
    commands.hear(COMMAND_RAMP, ramp_message(NOW - age, length=1.0))
    commands.hear(PANDA_COMMAND, arm_message(NOW - age))
    assert not commands.velocity(NOW).any()


def test_a_clock_that_goes_back_ends_a_command():
    commands = ArmCommands()
    commands.hear(COMMAND_RAMP, ramp_message(length=1.0))
    commands.hear(PANDA_COMMAND, arm_message())
    assert commands.velocity(NOW).any()
    assert not commands.velocity(NOW - 1).any()


@pytest.mark.parametrize(
    "ramp",
    [
        ramp_message(NOW - 1),
        ramp_message(period=0.0),
        ramp_message(length=math.nan),
        ramp_message(length=-1.0),
        b"nonsense",
    ],
)
def test_without_its_own_ramp_a_command_expires(ramp):
    commands = ArmCommands()
    commands.hear(COMMAND_RAMP, ramp)
    commands.hear(PANDA_COMMAND, arm_message())
    assert commands.velocity(NOW)[0] == pytest.approx(0.1)
    assert commands.velocity(NOW + EXPIRY)[0] == pytest.approx(0.1)
    assert not commands.velocity(NOW + EXPIRY + 1).any()


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
    done = base_velocity(np.array(done))
    np.testing.assert_allclose(
        clamped(base_velocity(np.array(asked)), BaseMaxima()), done
    )


@pytest.mark.parametrize(
    ("sideways", "done"), [(0.2, [0.2, 0.2, 0.1]), (0.0, [0.0, 0.0, 0.0])]
)
def test_a_base_goes_aside_as_far_as_it_can(sideways, done):
    """Half of the command at 0.2 m/s; nothing of it where that is missing."""
    asked = np.array([0.4, 0.4, 0.2])
    np.testing.assert_allclose(
        clamped(asked, BaseMaxima(sideways=sideways)), done
    )


def test_a_clamped_turn_is_one_that_the_robots_node_accepts():
    # qcr/ros_omron_agv rejects what exceeds its 50 degrees a second.
    _, _, yaw_rate = clamped(np.array([0.0, 0.0, 3.0]), BaseMaxima())
    assert 0.8 < yaw_rate < math.radians(50)


@settings(max_examples=100)
@given(st.lists(st.floats(), min_size=3, max_size=3))
def test_no_command_exceeds_the_maxima(asked):
    done = clamped(np.array(asked), BaseMaxima(sideways=0.3))
    assert (done >= [-0.25, -0.3, -0.872]).all()
    assert (done <= [1.0, 0.3, 0.872]).all()
    if np.isfinite(asked).all():
        assert (np.sign(done) * np.sign(asked) >= 0).all()


def velocity(commands: BaseCommands, now: int, t: float) -> tuple:
    """Speed forward and turning rate; the base never goes aside."""
    forward, left, yaw_rate = commands.velocity(now, t).tolist()
    assert left == 0
    return forward, yaw_rate


@pytest.mark.parametrize("direction", [-1, 1])
def test_a_base_command_counts_until_it_expires(direction):
    commands = BaseCommands()
    commands.receive(base_message(), 5.0)
    edge = NOW + direction * EXPIRY
    assert velocity(commands, NOW, 5.0) == (0.5, 0.2)
    assert velocity(commands, edge, 5.1) == (0.5, 0.2)
    assert velocity(commands, edge + direction, 5.1) == (0.0, 0.0)
    assert velocity(commands, NOW, 5.1) == (0.0, 0.0)


def test_silence_stops_the_base_whatever_the_clock_says():
    commands = BaseCommands()
    commands.receive(base_message(), 5.0)
    assert velocity(commands, NOW, 5.199) == (0.5, 0.2)
    assert velocity(commands, NOW, 5.201) == (0.0, 0.0)


def test_a_ramp_leads_the_base_to_rest_beyond_its_watchdog():
    commands = BaseCommands()
    commands.hear(COMMAND_RAMP, ramp_message(length=1.0), 5.0)
    commands.hear(BASE_COMMAND, base_message(), 5.0)
    for age, share in ((0.0, 1.0), (0.0149, 1.0), (0.3, 1 - 0.29), (1.1, 0.0)):
        found = velocity(commands, NOW + round(1e6 * age), 5.0 + age)
        assert found == pytest.approx((0.5 * share, 0.2 * share))
    # The wall clock may jump; the ramp goes by one that does not.
    commands.hear(COMMAND_RAMP, ramp_message(length=1.0), 6.0)
    commands.hear(BASE_COMMAND, base_message(), 6.0)
    assert velocity(commands, NOW, 6.0) == (0.5, 0.2)
    assert velocity(commands, 0, 6.01) == (0.5, 0.2)


def test_a_base_command_that_comes_late_has_no_ramp():
    commands = BaseCommands()
    late = NOW - EXPIRY - 1
    commands.hear(COMMAND_RAMP, ramp_message(late, length=1.0), 5.0)
    commands.hear(BASE_COMMAND, base_message(late), 5.0)
    assert velocity(commands, NOW, 5.0) == (0.0, 0.0)
    assert velocity(commands, late, 5.0) == (0.0, 0.0)


def test_bytes_that_are_no_base_command_are_ignored():
    commands = BaseCommands()
    for data in (b"", b"nonsense", base_message()[:-3]):
        commands.receive(data, 0.0)
    assert commands.received == 0
    assert velocity(commands, NOW, 0.0) == (0.0, 0.0)
