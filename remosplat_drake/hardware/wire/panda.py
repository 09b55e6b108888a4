"""LCM messages of the arm: lcmt_panda_command and lcmt_panda_status.

drake-franka-driver in velocity mode has the same rules. It exits after a
command with another mode or other array lengths.
"""

import dataclasses as dc

import numpy as np
from drake import lcmt_panda_command, lcmt_panda_status

from remosplat_drake.hardware.wire.packets import (
    BrokenMessage,
    decode,
    finite_number,
    finite_vector,
    from_utime,
    to_utime,
)

VELOCITY_MODE = lcmt_panda_status.CONTROL_MODE_VELOCITY
"""The control mode that every command states; the driver must be in it."""

MODE_NAMES = {
    lcmt_panda_status.kOther: "other",
    lcmt_panda_status.kIdle: "idle",
    lcmt_panda_status.kMove: "move",
    lcmt_panda_status.kGuiding: "guiding",
    lcmt_panda_status.kReflex: "reflex",
    lcmt_panda_status.kUserStopped: "user_stopped",
    lcmt_panda_status.kAutomaticErrorRecovery: "automatic_error_recovery",
}
"""Libfranka's names of the arm's modes, keyed by their numbers."""


@dc.dataclass(frozen=True, eq=False)
class PandaState:
    """Measurements of the arm's driver; a copy is the object itself.

    Attributes:
        q: Joint positions, shape (n,) [rad].
        v: Joint rates, shape (n,) [rad/s].
        stamp: Time of measurement, by the driver's wall clock [s].
        robot_stamp: The robot's own clock [s]; 0 if it is not sent.
        robot_mode: A key of `MODE_NAMES`.
        success_rate: Fraction of the last 100 packets that reached the robot, 0
            to 1. It is 0 if no commands are sent.
    """

    q: np.ndarray
    v: np.ndarray
    stamp: float
    robot_stamp: float
    robot_mode: int
    success_rate: float

    def __deepcopy__(self, memo) -> "PandaState":
        return self


def encode_panda_command(v: np.ndarray, time: float) -> bytes:
    """Encodes a velocity command to the arm.

    Args:
        v: Joint rates, shape (n,) [rad/s].
        time: Wall clock now [s].
    """
    message = lcmt_panda_command()
    message.utime = to_utime(time)
    message.num_joint_velocity = len(v)
    message.joint_velocity = [float(x) for x in v]
    message.control_mode_expected = VELOCITY_MODE
    return message.encode()


def decode_panda_status(data: bytes, n: int) -> PandaState:
    """Decodes and checks a status of the arm.

    Args:
        data: The encoded packet.
        n: Number of the arm's joints.

    Raises:
        BrokenMessage: The packet is not a status of an arm with n joints.
    """
    message = decode(lcmt_panda_status, data)
    if message.num_joints != n:
        raise BrokenMessage(f"has {message.num_joints} joints, not {n}")
    if message.robot_mode not in MODE_NAMES:
        valid = ", ".join(map(str, MODE_NAMES))
        raise BrokenMessage(
            f"robot_mode is {message.robot_mode}; valid: {valid}"
        )
    return PandaState(
        q=finite_vector("joint_position", message.joint_position, n),
        v=finite_vector("joint_velocity", message.joint_velocity, n),
        stamp=from_utime(message.utime),
        robot_stamp=from_utime(message.robot_utime),
        robot_mode=message.robot_mode,
        success_rate=finite_number(
            "control_command_success_rate",
            message.control_command_success_rate,
        ),
    )
