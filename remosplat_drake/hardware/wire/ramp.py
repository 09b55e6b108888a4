"""The braking ramp on the wire: how a robot brakes that receives nothing more.

Base and arm brake by one ramp, so that the robot stays on the path that was
verified. Each driver has its own axes only, so the message contains the ramp's
length.
"""

import dataclasses as dc

from remosplat_drake.hardware.wire.messages.command_ramp import command_ramp
from remosplat_drake.hardware.wire.packets import (
    BrokenMessage,
    decode,
    finite_number,
    to_utime,
)
from remosplat_drake.robot.braking import held_share

_LONGEST = 60.0
"""Longest period, and longest ramp, that are no mistake [s]."""


@dc.dataclass(frozen=True)
class Ramp:
    """How a robot brakes after a command.

    Attributes:
        utime: The command's stamp [us].
        period: Control period [s].
        length: How long the ramp from the command to zero takes [s].
    """

    utime: int
    period: float
    length: float

    def share(self, age: float) -> float:
        """Returns which share of the command is executed, 0 to 1.

        Args:
            age: Time since the command came [s].
        """
        return held_share(age, self.period, self.length)


def encode_ramp(time: float, period: float, length: float) -> bytes:
    """Encodes the ramp of the command that follows.

    Args:
        time: The command's stamp, by the wall clock [s].
        period: Control period [s].
        length: How long the ramp from the command to zero takes [s].
    """
    message = command_ramp()
    message.utime = to_utime(time)
    message.period, message.ramp = float(period), float(length)
    return message.encode()


def decode_ramp(data: bytes) -> Ramp:
    """Decodes and checks a ramp.

    Args:
        data: The encoded packet.

    Raises:
        BrokenMessage: The packet is not a ramp.
    """
    message = decode(command_ramp, data)
    period = finite_number("period", message.period)
    length = finite_number("ramp", message.ramp)
    if not (0.0 < period <= _LONGEST and 0.0 <= length <= _LONGEST):
        raise BrokenMessage(
            f"a ramp of {length} s in steps of {period} s, expected 0 to"
            f" {_LONGEST:g} s"
        )
    return Ramp(message.utime, period, length)
