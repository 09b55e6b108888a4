"""Encodes and decodes the braking ramp that follows a robot's command.

Drivers follow the ramp if they receive no newer command. Base and arm brake by
the same ramp, so that the robot stays on the verified path. A driver controls
only its own axes, so the message contains the ramp's duration.
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
"""Longest plausible period, and longest plausible ramp [s]."""


@dc.dataclass(frozen=True)
class Ramp:
    """The braking ramp of a robot after a command.

    Attributes:
        utime: The command's stamp [us].
        period: Control period [s].
        length: Duration of the ramp from the command to zero [s].
    """

    utime: int
    period: float
    length: float

    def share(self, age: float) -> float:
        """Returns the factor by which the command is scaled, 0 to 1.

        Args:
            age: Time since the arrival of the command [s].
        """
        return held_share(age, self.period, self.length)


def encode_ramp(time: float, period: float, length: float) -> bytes:
    """Encodes the ramp of the next command.

    Args:
        time: The command's stamp, by the wall clock [s].
        period: Control period [s].
        length: Duration of the ramp from the command to zero [s].
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
            f"a ramp of {length} s in steps of {period} s; both must be at"
            f" most {_LONGEST:g} s, and a step longer than 0 s"
        )
    return Ramp(message.utime, period, length)
