"""The arm's messages, byte by byte what its driver wants."""

import numpy as np
import pytest
from drake import lcmt_panda_command, lcmt_panda_status
from pydrake.manipulation import PandaControlMode

from remosplat_drake.hardware.wire.packets import BrokenMessage
from remosplat_drake.hardware.wire.panda import (
    MODE_NAMES,
    decode_panda_status,
    encode_panda_command,
)

T = 1_700_000_000.123456


def status(**fields) -> bytes:
    """A status of an arm that moves, with some fields replaced."""
    message = lcmt_panda_status()
    n = fields.pop("num_joints", 7)
    message.utime = round(T * 1e6)
    message.robot_utime = 2_500_000
    message.num_joints = n
    for name in message.__slots__:
        if name.startswith("joint_"):
            setattr(message, name, [0.0] * n)
    message.joint_position = [0.1 * i for i in range(n)]
    message.joint_velocity = [-0.2 * i for i in range(n)]
    message.robot_mode = lcmt_panda_status.kMove
    message.control_command_success_rate = 0.98
    for name, value in fields.items():
        setattr(message, name, value)
    return message.encode()


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
    state = decode_panda_status(status(), 7)
    np.testing.assert_array_equal(state.q, 0.1 * np.arange(7))
    np.testing.assert_array_equal(state.v, -0.2 * np.arange(7))
    assert state.stamp == pytest.approx(T, abs=1e-6)
    assert state.robot_stamp == 2.5
    assert MODE_NAMES[state.robot_mode] == "move"
    assert state.success_rate == 0.98


@pytest.mark.parametrize(
    ("data", "problem"),
    [
        (status(num_joints=6), "has 6 joints, not 7"),
        (
            status(joint_position=[0.0] * 3 + [np.nan] + [0.0] * 3),
            r"joint_position\[3\] is nan",
        ),
        (
            status(joint_velocity=[0.0] * 6 + [np.inf]),
            r"joint_velocity\[6\] is inf",
        ),
        (
            status(control_command_success_rate=np.nan),
            "control_command_success_rate is nan",
        ),
        (status(robot_mode=17), "robot_mode is 17"),
        (status()[:-1], "is not a whole lcmt_panda_status"),
        (b"", "is not a whole lcmt_panda_status"),
        (lcmt_panda_command().encode(), "is not a whole lcmt_panda_status"),
    ],
)
def test_a_broken_status_is_named(data, problem):
    with pytest.raises(BrokenMessage, match=problem):
        decode_panda_status(data, 7)
