"""Reads and writes the seen space of a splat, the file `SPLAT.seen`.

The file has the format of `array_file`. It contains the states of all voxels
(two bits each, deflated), the box that the voxels fill, in the splat's frame G,
and the digest of the splat's file. It is not valid for another splat.
"""

import math
import zlib
from pathlib import Path

import numpy as np

from remosplat_drake.base.array_file import (
    FileKind,
    open_arrays,
    write_arrays,
)
from remosplat_drake.base.errors import FileError
from remosplat_drake.reconstruction.report.quality_report import file_digest
from remosplat_drake.signals.coverage import SURFACE, Coverage

SUFFIX = ".seen"
"""Suffix of the names of these files."""

KIND = FileKind("file of seen space", b"RSSEEN\r\n", 1)

MOST_VOXELS = 20_000_000
"""A file holds at most this many voxels; more would take many seconds to read.
"""

_FARTHEST = 1e4  # Largest distance of a grid from the origin [m].


def seen_path(splat: Path) -> Path:
    """Returns the path of the seen space of a splat file."""
    return splat.with_suffix(SUFFIX)


def write_seen_space(splat: Path, coverage: Coverage) -> None:
    """Writes seen space beside the splat file, atomically.

    Args:
        splat: The splat file. It must not change afterwards.
        coverage: The seen space of its capture, in the splat's frame.

    Raises:
        FileError: The splat cannot be read or the file not written.
    """
    first, second = coverage.state & 1, coverage.state >> 1
    bits = np.packbits(np.stack([first, second]))
    write_arrays(
        seen_path(splat),
        KIND,
        {
            "splat_digest": file_digest(splat),
            "lower": coverage.lower.tolist(),
            "voxel": coverage.voxel,
            "shape": list(coverage.state.shape),
        },
        {"state": np.frombuffer(zlib.compress(bits.tobytes(), 6), np.uint8)},
    )


def read_seen_space(path: Path, splat: Path) -> Coverage:
    """Reads the seen space of a splat's capture.

    Args:
        path: The file.
        splat: The splat file that it must belong to.

    Returns:
        The voxels, in the splat's frame.

    Raises:
        FileError: The file is missing or damaged, has another kind or version,
            or belongs to another splat.
        FieldError: A field of it is missing or unusable.
    """
    file = open_arrays(path, KIND, None)
    head = file.document
    if head.text("splat_digest") != file_digest(splat):
        raise FileError(
            path,
            f"belongs to another splat than {splat.name}; create both again "
            "with `remosplat reconstruct`",
        )
    lower = np.array(head.numbers("lower", 3))
    if np.abs(lower).max() > _FARTHEST:
        raise head.error("lower", f"must lie within {_FARTHEST:g} m")
    shape = head.wholes("shape")
    if len(shape) != 3 or not 0 < math.prod(shape) <= MOST_VOXELS:
        problem = f"expected three numbers, {MOST_VOXELS:,} voxels at most"
        raise head.error("shape", problem)
    state = _unpack(path, file.array("state"), shape)
    return Coverage(lower, head.number("voxel", 1e-3, 10.0), state)


def _unpack(path: Path, packed: np.ndarray, shape: list[int]) -> np.ndarray:
    """Unpacks deflated states to an array (nx, ny, nz)."""
    size = 2 * math.prod(shape)
    damaged = FileError(path, "is damaged: its number of voxels is wrong")
    try:
        unpacker = zlib.decompressobj()
        # A damaged file must not fill the memory.
        bits = unpacker.decompress(packed.tobytes(), -(-size // 8))
        complete = unpacker.decompress(unpacker.unconsumed_tail, 1) == b""
    except zlib.error as error:
        raise damaged from error
    if len(bits) != -(-size // 8) or not complete or not unpacker.eof:
        raise damaged
    flat = np.unpackbits(np.frombuffer(bits, np.uint8), count=size)
    first, second = flat.reshape(2, *shape)
    state = first | second << 1
    if state.max() > SURFACE:
        raise FileError(path, "is damaged: it contains unknown states")
    return state
