"""Motions that no arm can do."""

import numpy as np
import pytest
from wire_messages import arm_message

from remosplat_drake.hardware.client.measurement import (
    Measurement,
    with_arm_status,
)
from remosplat_drake.hardware.hardware_config import HardwareConfig

LIMIT = np.full(7, 2.0)


def after(*messages: tuple[float, float, float]) -> Measurement:
    """Statuses of time, position and speed of joint 1 [s, rad, rad/s]."""
    measurement = Measurement()
    for time, q, v in messages:
        fields = {
            "utime": round(1e6 * time),
            "robot_utime": round(1e6 * time),
            "joint_position": [q, *[0.0] * 6],
            "joint_velocity": [v, *[0.0] * 6],
        }
        measurement = with_arm_status(
            measurement, arm_message(**fields), time, 7, HardwareConfig(), LIMIT
        )
    return measurement


@pytest.mark.parametrize(
    ("messages", "said"),
    [
        ([(1.0, 0.0, 0.0), (1.01, 0.039, 2.0)], ""),
        ([(1.0, 0.0, 0.0), (1.01, 0.6, 0.0)], "joint 1 jumped by 0.600 rad"),
        ([(1.0, 0.0, 0.0), (1.01, 0.0, 9.0)], "reports 9.00 rad/s"),
        # After a pause it may be elsewhere.
        ([(1.0, 0.0, 0.0), (1.5, 0.6, 0.0)], ""),
        # A clock that goes back is another fault, and has its own name.
        ([(5.0, 0.0, 0.0), (1.01, 0.01, 0.0)], ""),
    ],
)
def test_a_joint_cannot_jump(messages, said):
    stream = after(*messages).arm_stream
    assert said in stream.broken
    assert bool(stream.broken) == bool(said)


def test_a_jump_is_over_with_the_next_message_and_the_state_goes_with_it():
    jumped = after((1.0, 0.0, 0.0), (1.01, 0.6, 0.0), (1.02, 0.6, 0.0))
    assert jumped.arm_stream.broken == ""
    assert jumped.arm is not None and jumped.arm.q[0] == 0.6
