"""Packets, checked, and their stamps: microseconds of the Unix epoch.

Both ends of the wire read by these rules, so that they agree on what is
broken and on what has expired.
"""

import math
import struct

import numpy as np


class BrokenMessage(ValueError):
    """A message that must not be used; its text says what is wrong."""


def to_utime(time: float) -> int:
    """A wall clock time [s] as microseconds."""
    return round(time * 1e6)


def from_utime(utime: int) -> float:
    """Microseconds as a wall clock time [s], good to 0.3 microseconds."""
    return utime * 1e-6


def is_expired(utime: int, now: int, expiry: float) -> bool:
    """Whether a stamp is too far from the clock, into the past or future.

    Args:
        utime: The stamp [us].
        now: The reader's wall clock [us].
        expiry: How far it may be [s].
    """
    return abs(now - utime) > to_utime(expiry)


def decode(message_type, data: bytes):
    """The message in a packet.

    Raises:
        BrokenMessage: The packet holds another type or is cut short.
    """
    try:
        return message_type.decode(data)
    except (ValueError, struct.error) as error:
        name = message_type.__name__
        raise BrokenMessage(f"is not a whole {name}") from error


def finite_vector(name: str, values, size: int) -> np.ndarray:
    """A field of a message as an array of known length.

    Raises:
        BrokenMessage: The length is wrong or a number is not finite.
    """
    array = np.array(values, float)
    if array.shape != (size,):
        raise BrokenMessage(f"{name} has {array.size} numbers, not {size}")
    broken = ~np.isfinite(array)
    if broken.any():
        i = int(broken.argmax())
        raise BrokenMessage(f"{name}[{i}] is {array[i]}")
    return array


def finite_number(name: str, value: float) -> float:
    """A field of a message as a number.

    Raises:
        BrokenMessage: It is not finite.
    """
    if not math.isfinite(value):
        raise BrokenMessage(f"{name} is {value}")
    return float(value)
