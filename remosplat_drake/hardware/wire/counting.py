"""Reads and writes counting_map: which map version a control loop uses.

A loop with a growing map sends this version continuously, for programs that
search for objects that the map does not contain.
"""

import dataclasses as dc

from remosplat_drake.hardware.wire.messages.counting_map import counting_map
from remosplat_drake.hardware.wire.packets import (
    BrokenMessage,
    decode,
    is_expired,
    to_utime,
)

PERIOD = 0.2
"""Time between two messages [s]."""

EXPIRY = 1.0
"""Age at which a message is ignored [s]."""


@dc.dataclass(frozen=True)
class CountingMap:
    """The version of a session's map that counts.

    Attributes:
        version: Its number; 0 is the map that the scenario begins with.
        revision: Name of its content, the `DistanceField`'s.
    """

    version: int
    revision: str


def encode_counting(counting: CountingMap, now: float) -> bytes:
    """Encodes which map counts.

    Args:
        counting: The version.
        now: The sender's wall clock [s].
    """
    message = counting_map()
    message.utime = to_utime(now)
    message.version, message.revision = counting.version, counting.revision
    return message.encode()


def decode_counting(data: bytes, now: float) -> CountingMap | None:
    """Decodes which map counts.

    Args:
        data: The encoded packet.
        now: Our wall clock [s].

    Returns:
        The version; None if the message is old, or from the future.

    Raises:
        BrokenMessage: The packet holds something else, or no version.
    """
    message = decode(counting_map, data)
    if is_expired(message.utime, to_utime(now), EXPIRY):
        return None
    if message.version < 0 or not message.revision:
        raise BrokenMessage(
            f"names no map: version {message.version} of {message.revision!r}"
        )
    return CountingMap(message.version, message.revision)
