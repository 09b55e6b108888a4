"""Maps as files that are opened without being read: `*.rsmap`.

A file holds a pickle whose arrays lie outside of it, one after the other.
Opening maps the file into memory and lets the arrays point there, so that a
control process has a new map, hierarchy and all, in about a millisecond; what
a query touches is in memory already where the file was just written.

Layout: the header `_HEADER`, the places of the arrays as pairs (offset, size)
of 8 bytes each, the pickle, and the arrays at multiples of 64 bytes. Numbers
are little-endian.
"""

import io
import mmap
import pickle
import struct
import zlib
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from remosplat_drake.atomic_file import atomic_write
from remosplat_drake.errors import FileError
from remosplat_drake.mapping.scene_map import SceneMap

SUFFIX = ".rsmap"
MAGIC = b"RSMAP\r\n\0"
FORMAT = 1

_HEADER = struct.Struct("<8sIIQQII")
"""Magic, format, number of arrays, size of the pickle, size of the file,
checksums of what stands before the arrays and of the arrays (CRC-32)."""

_ALIGNMENT = 64
"""A cache line: kernels read records that fill some exactly."""

_OURS = tuple(
    f"remosplat_drake.{room}."
    for room in ("mapping", "oracle", "reconstruction", "splat")
)
_NUMPY = {
    ("numpy", "dtype"),
    ("numpy", "ndarray"),
    ("numpy._core.multiarray", "_reconstruct"),
    ("numpy._core.multiarray", "scalar"),
    ("numpy._core.numeric", "_frombuffer"),
}
"""What a file may name besides our own classes: numpy's way of pickling."""


def write_map(path: str | Path, scene_map: SceneMap) -> None:
    """Writes a map, whole or not at all.

    Raises:
        FileError: The file cannot be written, because the disk is full for
            example, or the map holds what no file can: a field on a GPU.
    """
    path = Path(path)
    arrays: list[memoryview] = []

    def keep(buffer: pickle.PickleBuffer) -> None:
        arrays.append(buffer.raw())

    try:
        body = pickle.dumps(scene_map, protocol=5, buffer_callback=keep)
        _unpickle(body, arrays)
    except (pickle.PickleError, TypeError, AttributeError) as error:
        raise FileError(path, f"this map fits in no file: {error}") from error
    places, end = _places(_HEADER.size + 16 * len(arrays) + len(body), arrays)
    front = np.array(places, "<u8").tobytes() + body
    header = _HEADER.pack(
        MAGIC,
        FORMAT,
        len(arrays),
        len(body),
        end,
        zlib.crc32(front),
        _checksum(arrays),
    )
    with atomic_write(path, "wb") as file:
        file.write(header + front)
        for (offset, _), array in zip(places, arrays, strict=True):
            file.write(bytes(offset - file.tell()))
            file.write(array)


def open_map(path: str | Path, *, check: bool = False) -> SceneMap:
    """Opens a map; its arrays are views of the file.

    The file may be deleted or replaced meanwhile, but not written into.

    Args:
        path: The file.
        check: Read the arrays as well, to find damage that happened to the
            file since it was written: some milliseconds.

    Raises:
        FileError: The file is missing, no map, cut off, or damaged.
    """
    path = Path(path)
    data = _memory(path)
    if len(data) < _HEADER.size:
        raise FileError(path, "is no map: it is too short")
    magic, version, count, size, end, front_sum, sums = _HEADER.unpack(
        data[: _HEADER.size]
    )
    if magic != MAGIC:
        raise FileError(path, f"is no map ({SUFFIX})")
    if version != FORMAT:
        raise FileError(
            path, f"is a map of format {version}; this program reads {FORMAT}"
        )
    if len(data) != end:
        raise FileError(
            path, f"is cut off: it has {len(data)} bytes instead of {end}"
        )
    start = _HEADER.size + 16 * count
    front = data[_HEADER.size : start + size]
    if zlib.crc32(front) != front_sum:
        raise FileError(path, "is damaged: its checksum is wrong")
    places = np.frombuffer(front, "<u8", 2 * count).reshape(-1, 2).tolist()
    arrays = [data[offset : offset + length] for offset, length in places]
    if check and _checksum(arrays) != sums:
        raise FileError(path, "is damaged: the checksum of its arrays is wrong")
    try:
        scene_map = _unpickle(front[16 * count :], arrays)
    except Exception as error:  # Other versions of our classes: anything.
        raise FileError(
            path, f"holds no map of this program: {error}"
        ) from error
    if not isinstance(scene_map, SceneMap):
        raise FileError(path, "holds something else than a map")
    return scene_map


def _memory(path: Path) -> memoryview:
    """The file, mapped into memory.

    Privately and writable: arrays that were writable when they were written
    stay so, and are what kernels have been compiled for.
    """
    try:
        with path.open("rb") as file:
            return memoryview(
                mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_COPY)
            )
    except OSError as error:
        raise FileError(path, error.strerror or str(error)) from error
    except ValueError as error:  # An empty file cannot be mapped.
        raise FileError(path, "is no map: it is empty") from error


def _places(
    start: int, arrays: Sequence[memoryview]
) -> tuple[list[tuple[int, int]], int]:
    """Offset and size of each array in the file, and the file's size."""
    places, end = [], start
    for array in arrays:
        offset = -(-end // _ALIGNMENT) * _ALIGNMENT
        places.append((offset, array.nbytes))
        end = offset + array.nbytes
    return places, end


def _checksum(arrays: Sequence[memoryview]) -> int:
    total = 0
    for array in arrays:
        total = zlib.crc32(array, total)
    return total


def _unpickle(body: bytes | memoryview, arrays: Sequence[memoryview]) -> object:
    return _MapUnpickler(io.BytesIO(body), buffers=arrays).load()


class _MapUnpickler(pickle.Unpickler):
    """Makes our own classes and arrays, and calls nothing else."""

    def find_class(self, module: str, name: str) -> object:
        if (module, name) in _NUMPY:
            return super().find_class(module, name)
        if module.startswith(_OURS) and "." not in name:
            found = super().find_class(module, name)
            if isinstance(found, type) and found.__module__ == module:
                return found
        raise pickle.UnpicklingError(f"{module}.{name} is not part of a map")
