"""The gripper on the wire: lcmt_schunk_wsg_command out, ..._status in."""

import dataclasses as dc

import numpy as np
from drake import lcmt_schunk_wsg_command, lcmt_schunk_wsg_status

from remosplat_drake.hardware.wire.packets import (
    decode,
    finite_vector,
    from_utime,
    to_utime,
)


@dc.dataclass(frozen=True, eq=False)
class HandState:
    """What the gripper's driver measured; copying returns the object itself.

    Attributes:
        width: Opening and its rate [m, m/s], shape (2,).
        stamp: Wall clock of the driver [s].
    """

    width: np.ndarray
    stamp: float

    def __deepcopy__(self, memo) -> "HandState":
        return self


def encode_hand_command(width: float, force: float, time: float) -> bytes:
    """A command to the gripper.

    Args:
        width: Opening [m]; millimetres on the wire.
        force: Bound on the gripping force [N].
        time: Wall clock now [s].
    """
    message = lcmt_schunk_wsg_command()
    message.utime = to_utime(time)
    message.target_position_mm = 1e3 * width
    message.force = force
    return message.encode()


def decode_hand_status(data: bytes) -> HandState:
    """The gripper's state, checked.

    Raises:
        BrokenMessage: The packet is not a status of a gripper.
    """
    message = decode(lcmt_schunk_wsg_status, data)
    millimetres = [message.actual_position_mm, message.actual_speed_mm_per_s]
    width = 1e-3 * finite_vector("actual_position_mm", millimetres, 2)
    return HandState(width, from_utime(message.utime))
