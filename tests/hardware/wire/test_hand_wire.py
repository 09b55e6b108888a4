"""The gripper's messages are in millimetres, its ports in metres."""

import numpy as np
import pytest
from drake import lcmt_schunk_wsg_command, lcmt_schunk_wsg_status

from remosplat_drake.hardware.wire.hand import (
    decode_hand_status,
    encode_hand_command,
)
from remosplat_drake.hardware.wire.packets import BrokenMessage


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
