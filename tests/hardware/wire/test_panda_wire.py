"""The arm's messages, byte by byte what its driver wants."""

import numpy as np
import pytest
from drake import lcmt_panda_command
from pydrake.manipulation import PandaControlMode
from wire_messages import arm_message

from remosplat_drake.hardware.wire.packets import BrokenMessage
from remosplat_drake.hardware.wire.panda import (
    MODE_NAMES,
    decode_panda_status,
    encode_panda_command,
)

T = 1_700_000_000.123456


def test_a_command_is_what_the_driver_takes():
    v = np.arange(7) / 10
    message = lcmt_panda_command.decode(encode_panda_command(v, T))
    assert message.utime == 1_700_000_000_123_456
    assert message.control_mode_expected == int(PandaControlMode.kVelocity)
    assert message.num_joint_velocity == 7
    assert list(message.joint_velocity) == v.tolist()
    assert message.num_joint_position == message.num_joint_torque == 0
    assert len(message.joint_position) == len(message.joint_torque) == 0


def test_a_status_is_read():
    state = decode_panda_status(arm_message(), 7)
    np.testing.assert_array_equal(state.q, 0.1 * np.arange(7))
    np.testing.assert_array_equal(state.v, -0.2 * np.arange(7))
    assert state.stamp == pytest.approx(T, abs=1e-6)
    assert state.robot_stamp == 2.5
    assert MODE_NAMES[state.robot_mode] == "move"
    assert state.success_rate == 0.98


@pytest.mark.parametrize(
    ("data", "problem"),
    [
        (arm_message(num_joints=6), "has 6 joints, not 7"),
        (
            arm_message(joint_position=[0.0] * 3 + [np.nan] + [0.0] * 3),
            r"joint_position\[3\] is nan",
        ),
        (
            arm_message(joint_velocity=[0.0] * 6 + [np.inf]),
            r"joint_velocity\[6\] is inf",
        ),
        (
            arm_message(control_command_success_rate=np.nan),
            "control_command_success_rate is nan",
        ),
        (arm_message(robot_mode=17), "robot_mode is 17"),
        (arm_message()[:-1], "is not a whole lcmt_panda_status"),
        (b"", "is not a whole lcmt_panda_status"),
        (lcmt_panda_command().encode(), "is not a whole lcmt_panda_status"),
    ],
)
def test_a_broken_status_is_named(data, problem):
    with pytest.raises(BrokenMessage, match=problem):
        decode_panda_status(data, 7)
