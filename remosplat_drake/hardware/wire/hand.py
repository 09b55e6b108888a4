"""LCM messages of the gripper: lcmt_schunk_wsg_command and _status."""

import dataclasses as dc

import numpy as np
from drake import lcmt_schunk_wsg_command, lcmt_schunk_wsg_status

from remosplat_drake.base.errors import FieldError
from remosplat_drake.hardware.wire.packets import (
    decode,
    finite_vector,
    from_utime,
    to_utime,
)
from remosplat_drake.robot.robot_description import RobotDescription


@dc.dataclass(frozen=True, eq=False)
class HandState:
    """Measurements of the gripper's driver; a copy is the object itself.

    Attributes:
        reading: Opening of the fingers, its rate, and the force with which each
            finger presses, shape (3,) [m, m/s, N].
        stamp: Time of measurement, by the driver's wall clock [s].
    """

    reading: np.ndarray
    stamp: float

    def __deepcopy__(self, memo) -> "HandState":
        return self


def check_hands(description: RobotDescription) -> None:
    """Checks that a robot has at most one hand, since hands have one channel.

    Args:
        description: The robot.

    Raises:
        FieldError: The robot has several hands.
    """
    count = len(description.effector_hands)
    if count > 1:
        problem = f"a real robot may have at most one hand, got {count}"
        raise FieldError(description.source, "hands", problem)


def encode_hand_command(width: float, force: float, time: float) -> bytes:
    """Encodes a command to the gripper.

    Args:
        width: Commanded opening [m]; the message contains it in millimetres.
        force: Bound on the gripping force [N].
        time: Wall clock now [s].
    """
    message = lcmt_schunk_wsg_command()
    message.utime = to_utime(time)
    message.target_position_mm = 1e3 * width
    message.force = force
    return message.encode()


def decode_hand_status(data: bytes) -> HandState:
    """Decodes and checks a status of the gripper.

    Raises:
        BrokenMessage: The packet is not a status of a gripper.
    """
    message = decode(lcmt_schunk_wsg_status, data)
    millimetres = [message.actual_position_mm, message.actual_speed_mm_per_s]
    width = 1e-3 * finite_vector("actual_position_mm", millimetres, 2)
    force = finite_vector("actual_force", [message.actual_force], 1)
    reading = np.concatenate([width, force])
    return HandState(reading, from_utime(message.utime))
