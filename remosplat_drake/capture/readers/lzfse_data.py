"""Unpacks LZFSE data (Apple's compression) with a limit of the size.

A block of a few bytes can unpack to megabytes. Each block's header contains its
packed and unpacked size, so the total size is checked before unpacking. For the
headers see lzfse_internal.h of Apple's reference (BSD licence).
"""

import struct

from remosplat_drake.base.errors import FileError, MissingExtraError
from remosplat_drake.capture.images import MAX_PIXELS, Source

MAX_BYTES = 4 * MAX_PIXELS
"""A file may unpack to at most this size, that of a float32 image of
`MAX_PIXELS` [bytes]."""


_MIN_HEADER = 32
"""Least size of a block of kind 2 [bytes]. Smaller sizes are invalid, so
reading always advances.
"""


def unpack(source: Source, max_bytes: int = MAX_BYTES) -> bytes:
    """Unpacks an LZFSE file.

    Args:
        source: The file.
        max_bytes: Largest size of the content [bytes].

    Raises:
        FileError: The file is missing, damaged or too long.
        MissingExtraError: lzfse is not installed.
    """
    try:
        import lzfse
    except ImportError as error:
        raise MissingExtraError(
            "depth of Record3D captures", "reconstruction"
        ) from error
    if not source.exists():
        raise FileError(str(source), "no such file")
    packed = source.read_bytes()
    try:
        if unpacked_size(packed) > max_bytes:
            raise FileError(
                str(source), f"unpacks to more than {max_bytes} bytes"
            )
        return lzfse.decompress(packed)
    # With damaged data, the decoder allocates more and more memory.
    except (ValueError, struct.error, lzfse.error, MemoryError) as error:
        raise FileError(
            str(source), f"damaged LZFSE data {error}".strip()
        ) from error


def unpacked_size(packed: bytes) -> int:
    """Adds up the unpacked sizes that the headers of all blocks state [bytes].

    Raises:
        ValueError: A block has an unknown kind, or the last block is missing.
        struct.error: The data end within a header.
    """
    total = position = 0
    while packed[position : position + 4] != b"bvx$":
        raw, length = _block(packed, position)
        total += raw
        position += length
    return total


def _block(packed: bytes, start: int) -> tuple[int, int]:
    """Unpacked and packed size of the block at `start` [bytes]."""
    kind = packed[start : start + 4]
    if kind == b"bvx-":
        (raw,) = struct.unpack_from("<I", packed, start + 4)
        return raw, 8 + raw
    if kind == b"bvxn":
        raw, payload = struct.unpack_from("<II", packed, start + 4)
        return raw, 12 + payload
    if kind == b"bvx2":
        raw, v0, v1, v2 = struct.unpack_from("<IQQQ", packed, start + 4)
        literals = (v0 >> 20) & 0xFFFFF
        matches = (v1 >> 40) & 0xFFFFF
        header = v2 & 0xFFFFFFFF
        return raw, max(header, _MIN_HEADER) + literals + matches
    raise ValueError(f"(block {kind!r} at {start})")
