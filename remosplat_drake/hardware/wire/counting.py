"""Encodes and decodes counting_map, the map version that a loop uses.

A control loop with a live map sends this version continuously. Detection
programs need it, since they report only objects that the map does not contain.
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
"""A message is ignored if its stamp differs from our clock by more than this
time [s]."""


@dc.dataclass(frozen=True)
class CountingMap:
    """The version of a session's map that is in use.

    Attributes:
        version: Number of the version; 0 is the scenario's own map.
        revision: Identifier of the map's content, `DistanceField.revision`.
    """

    version: int
    revision: str


def encode_counting(counting: CountingMap, now: float) -> bytes:
    """Encodes the map version in use.

    Args:
        counting: The version.
        now: The sender's wall clock [s].
    """
    message = counting_map()
    message.utime = to_utime(now)
    message.version, message.revision = counting.version, counting.revision
    return message.encode()


def decode_counting(data: bytes, now: float) -> CountingMap | None:
    """Decodes the map version in use.

    Args:
        data: The encoded packet.
        now: Our wall clock [s].

    Returns:
        The version; None if the stamp is stale, or in the future.

    Raises:
        BrokenMessage: The packet is another message, or has no version.
    """
    message = decode(counting_map, data)
    if is_expired(message.utime, to_utime(now), EXPIRY):
        return None
    if message.version < 0 or not message.revision:
        raise BrokenMessage(
            f"names no map: version {message.version} of {message.revision!r}"
        )
    return CountingMap(message.version, message.revision)
