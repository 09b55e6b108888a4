"""Limits the unpacked size of compressed splat files.

A file of a kilobyte can unpack to gigabytes. So each reader of a compressed
format checks sizes with this module before it unpacks any data.
"""

import struct
import zipfile
import zlib
from pathlib import Path

from remosplat_drake.base.errors import FileError

ZIP_DAMAGES = (
    zipfile.BadZipFile,
    zlib.error,
    struct.error,
    NotImplementedError,
    RuntimeError,
    ValueError,
    OSError,
    EOFError,
)
"""Exceptions of `zipfile` for archives that are damaged, encrypted or of an
unsupported kind."""

MAX_SPLATS = 2**24
"""A file may contain at most this many splats. A splat takes 50 to 350 bytes of
memory."""

_ALWAYS_ALLOWED = 2**26
"""For unpacked sizes up to this one, any compression ratio is accepted [bytes],
since uniform pictures have very large ratios."""

_MAX_RATIO = 1000
"""Largest compression ratio that is accepted for unpacked sizes above
`_ALWAYS_ALLOWED`. Real data do not reach it."""


def read_whole(path: Path) -> bytes:
    """Reads the bytes of a file.

    Raises:
        FileError: The file cannot be read.
    """
    try:
        return path.read_bytes()
    except OSError as error:
        raise FileError(path, error.strerror or str(error)) from error


def check_count(path: Path, count: int) -> None:
    """Checks the number of splats that a file declares.

    Raises:
        FileError: The number is zero, or larger than `MAX_SPLATS`.
    """
    if count < 1:
        raise FileError(path, "holds no splats")
    if count > MAX_SPLATS:
        raise FileError(
            path, f"declares {count} splats; at most {MAX_SPLATS} are read"
        )


def check_unpacked_size(path: Path, packed: int, unpacked: int) -> None:
    """Checks the compression ratio of a part of a file.

    Args:
        path: The file, for the error.
        packed: Size of the part in the file [bytes].
        unpacked: Unpacked size that the part declares [bytes].

    Raises:
        FileError: The unpacked size is implausibly large (a zip bomb).
    """
    if unpacked > max(_ALWAYS_ALLOWED, _MAX_RATIO * packed):
        raise FileError(
            path,
            f"{packed} bytes would unpack to {unpacked} bytes: the file is"
            " damaged, or made to exhaust the memory",
        )


def gunzip_at_most(path: Path, data: bytes, size: int) -> bytes:
    """Unpacks at most the first `size` bytes of gzipped data.

    Raises:
        FileError: The data is damaged or ends early.
    """
    stream = zlib.decompressobj(wbits=16 + zlib.MAX_WBITS)
    try:
        unpacked = stream.decompress(data, size)
    except zlib.error as error:
        raise FileError(path, f"damaged: {error}") from error
    if len(unpacked) < size and not stream.eof:
        raise FileError(path, "truncated: its compressed data ends early")
    return unpacked
