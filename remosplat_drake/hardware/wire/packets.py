"""Decodes and checks packets, and compares their stamps.

Stamps are microseconds of the Unix epoch. Controller and drivers use the same
functions, so they agree about malformed and expired messages.
"""

import math
import struct

import numpy as np


class BrokenMessage(ValueError):
    """Raised if a message must not be used; the error contains the reason."""


_STAMP = struct.Struct(">8xq")
"""Format of a message's first field, which follows LCM's fingerprint."""


def stamp_of(data: bytes) -> int | None:
    """Reads the stamp at the beginning of a message, without decoding it.

    Args:
        data: The encoded packet.

    Returns:
        The stamp [us]; None if the packet is too short.
    """
    if len(data) < _STAMP.size:
        return None
    return _STAMP.unpack_from(data)[0]


def to_utime(time: float) -> int:
    """Converts a wall clock time [s] to a stamp in microseconds."""
    return round(time * 1e6)


def from_utime(utime: int) -> float:
    """Converts a stamp in microseconds to a wall clock time [s].

    The rounding error of the result is up to 0.3 microseconds.
    """
    return utime * 1e-6


def is_expired(utime: int, now: int, expiry: float) -> bool:
    """Returns whether a stamp is too far from now, in the past or the future.

    Args:
        utime: The stamp [us].
        now: The reader's wall clock [us].
        expiry: Greatest difference between the two [s].
    """
    return abs(now - utime) > to_utime(expiry)


def decode(message_type, data: bytes):
    """Decodes the message in a packet.

    Args:
        message_type: An LCM type, such as `lcmt_panda_status`.
        data: The encoded packet.

    Raises:
        BrokenMessage: The packet is of another type or truncated.
    """
    try:
        return message_type.decode(data)
    except (ValueError, struct.error) as error:
        name = message_type.__name__
        raise BrokenMessage(f"is not a whole {name}") from error


def finite_vector(name: str, values, size: int) -> np.ndarray:
    """Checks a field of a message that is a list of numbers.

    Args:
        name: Name of the field, which the error contains.
        values: The numbers.
        size: Required number of values.

    Returns:
        The numbers, shape (size,).

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
    """Checks a field of a message that is a number.

    Args:
        name: Name of the field, which the error contains.
        value: The number.

    Raises:
        BrokenMessage: The number is not finite.
    """
    if not math.isfinite(value):
        raise BrokenMessage(f"{name} is {value}")
    return float(value)
