"""The gripper's messages are in millimetres, its ports in metres."""

import numpy as np
import pytest
from drake import lcmt_schunk_wsg_command, lcmt_schunk_wsg_status

from remosplat_drake.base.errors import FieldError
from remosplat_drake.hardware.wire.hand import (
    check_hands,
    decode_hand_status,
    encode_hand_command,
)
from remosplat_drake.hardware.wire.packets import BrokenMessage
from remosplat_drake.robot.robot_description import load_robot_description


def test_two_hands_are_refused():
    check_hands(load_robot_description("frankie"))
    check_hands(load_robot_description("ur5e"))
    message = r"two_pandas\.yaml.*hands: a real robot may have at most one hand"
    with pytest.raises(FieldError, match=message):
        check_hands(load_robot_description("two_pandas"))


def test_a_command_is_written():
    data = encode_hand_command(0.04, 20.0, 1.5)
    message = lcmt_schunk_wsg_command.decode(data)
    assert message.utime == 1_500_000
    assert (message.target_position_mm, message.force) == (40.0, 20.0)


def test_a_status_is_read():
    message = lcmt_schunk_wsg_status()
    message.utime = 2_000_000
    message.actual_position_mm = 80.0
    message.actual_speed_mm_per_s = -50.0
    message.actual_force = 12.0
    state = decode_hand_status(message.encode())
    np.testing.assert_allclose(state.reading, [0.08, -0.05, 12.0])
    assert state.stamp == 2.0


def test_a_broken_status_is_named():
    message = lcmt_schunk_wsg_status()
    message.actual_position_mm = np.nan
    with pytest.raises(BrokenMessage, match="is nan"):
        decode_hand_status(message.encode())
