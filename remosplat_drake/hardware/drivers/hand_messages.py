"""Messages for the Franka hand: Drake's for Schunk's gripper, in mm."""

import math

from drake import lcmt_schunk_wsg_command, lcmt_schunk_wsg_status

from remosplat_drake.hardware.wire.packets import BrokenMessage, decode

PERIOD = 0.1
"""Period of a hand driver's loop [s]."""

_MILLIMETRES = 1e3


def read_command(data: bytes) -> tuple[float, float] | None:
    """Decodes a command to the hand.

    Args:
        data: The encoded lcmt_schunk_wsg_command.

    Returns:
        Width and force [m, N]; None if the message is malformed.
    """
    try:
        message = decode(lcmt_schunk_wsg_command, data)
    except BrokenMessage:
        return None
    command = (message.target_position_mm / _MILLIMETRES, message.force)
    return command if all(map(math.isfinite, command)) else None


def hand_status(
    width: float, rate: float, force: float, now: int
) -> lcmt_schunk_wsg_status:
    """Makes the status message of a hand.

    Args:
        width: Opening of the fingers [m].
        rate: Rate of the opening [m/s].
        force: Force with which each finger presses [N].
        now: Wall clock [us].
    """
    message = lcmt_schunk_wsg_status()
    message.utime = now
    message.actual_position_mm = _MILLIMETRES * float(width)
    message.actual_speed_mm_per_s = _MILLIMETRES * float(rate)
    message.actual_force = float(force)
    return message
