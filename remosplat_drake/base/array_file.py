"""Writes and opens files of named arrays: `write_arrays`, `open_arrays`.

A file consists of a prefix of fixed size (`_PREFIX`), a JSON header, and the
arrays in little-endian order. Each array starts at a multiple of 64 bytes. The
header contains the caller's JSON document and, in the order of the arrays,
their names, types, shapes and checksums. The positions of the arrays are
computed from their types and shapes.

`write_arrays` returns the file's seal, which is the SHA-256 of the header. If a
caller passes the seal to `open_arrays`, the file is opened at once: its arrays
are mapped into memory and not read. Without the seal, every array is read and
checked.
"""

import dataclasses as dc
import hashlib
import json
import math
import mmap
import os
import struct
import zlib
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from remosplat_drake.base.atomic_file import atomic_write
from remosplat_drake.base.errors import FileError
from remosplat_drake.base.json_fields import JsonFields, parse_fields

_PREFIX = struct.Struct("<8sIIQ32s")
"""The prefix of a file: magic bytes, format version, sizes of the header and of
the file, and the header's SHA-256."""

_ALIGNMENT = 64
"""Alignment of arrays [bytes]. It is the size of a cache line, since some
kernels read records of whole cache lines."""

_LONGEST_HEADER = 1 << 20
_LARGEST_ARRAY = 1 << 40
"""An array is rejected if its size in the header exceeds this value [bytes]."""

_MOST_DIMENSIONS = 4

_TYPES = ("<f4", "<f8", "<i2", "<i4", "<i8", "|u1", "|b1")
"""Data types that the elements of an array may have."""


@dc.dataclass(frozen=True)
class FileKind:
    """A kind of array file, which its first bytes declare.

    Attributes:
        name: Name of such a file in messages.
        magic: The first 8 bytes of such a file.
        version: Version of its format.
    """

    name: str
    magic: bytes
    version: int


class VersionError(FileError):
    """Raised if a file's format has a version that is not supported."""


@dc.dataclass(frozen=True)
class _Place:
    """Position in the file, type, shape and checksum of an array."""

    dtype: str
    shape: list[int]
    first: int
    end: int
    crc32: int


@dc.dataclass(frozen=True)
class ArrayFile:
    """An open file of named arrays.

    Attributes:
        path: Path of the file.
        document: The JSON document that is stored with the arrays.
        is_sealed: Whether the file was opened with its seal, the SHA-256 of its
            header. If true, the arrays are views of the mapped file. If false,
            the file was read into memory, and the arrays are views of this
            memory and are checked.
    """

    path: Path
    document: JsonFields
    is_sealed: bool
    _data: memoryview
    _places: dict[str, _Place]

    def names(self) -> list[str]:
        """Lists the names of all arrays."""
        return list(self._places)

    def array(self, name: str) -> np.ndarray:
        """Returns an array.

        Raises:
            FileError: The file has no array of this name, or the array is
                damaged.
        """
        if name not in self._places:
            raise FileError(self.path, f"lacks the array {name!r}")
        place = self._places[name]
        data = self._data[place.first : place.end]
        if not self.is_sealed and zlib.crc32(data) != place.crc32:
            raise FileError(
                self.path, f"is damaged: the checksum of {name!r} is wrong"
            )
        return np.frombuffer(data, place.dtype).reshape(place.shape)


def write_arrays(
    path: Path,
    kind: FileKind,
    document: dict,
    arrays: Mapping[str, np.ndarray],
) -> str:
    """Writes a file of named arrays, atomically.

    Args:
        path: The file.
        kind: The kind of file to write.
        document: A document to store with the arrays; anything that JSON can
            hold.
        arrays: The arrays, keyed by name.

    Returns:
        The file's seal: the SHA-256 of its header, in hexadecimal.

    Raises:
        FileError: The file cannot be written, because the disk is full for
            example.
    """
    entries, pieces = {}, []
    for name, array in arrays.items():
        array = np.ascontiguousarray(array)
        pieces.append(array.reshape(-1).view(np.uint8).data)
        entries[name] = {
            "dtype": array.dtype.str,
            "shape": array.shape,
            "crc32": zlib.crc32(pieces[-1]),
        }
    header = json.dumps({"document": document, "arrays": entries}).encode()
    end = _aligned(_PREFIX.size + len(header))
    end += sum(_aligned(piece.nbytes) for piece in pieces)
    seal = hashlib.sha256(header)
    prefix = _PREFIX.pack(
        kind.magic, kind.version, len(header), end, seal.digest()
    )
    with atomic_write(path, "wb") as file:
        for piece in (prefix + header, *pieces):
            file.write(piece)
            file.write(bytes(_aligned(file.tell()) - file.tell()))
    return seal.hexdigest()


def open_arrays(path: Path, kind: FileKind, seal: str | None) -> ArrayFile:
    """Opens a file of named arrays.

    While a file that was opened with its seal is in use, it may be deleted or
    replaced, but its bytes must not be changed.

    Args:
        path: The file.
        kind: The kind of file that it must be.
        seal: The value that `write_arrays` returned in this run of the program.
            With it, the arrays are mapped into memory and not read. If it is
            None, the file is read, and each array is checked on first use.

    Raises:
        VersionError: The file's format has a version that is not supported.
        FileError: The file is missing, of another kind, truncated or damaged.
        FieldError: The file's header is damaged or contradicts itself.
    """
    data = _read(path) if seal is None else _map(path)
    header = _header(path, kind, data)
    if seal is not None and hashlib.sha256(header).hexdigest() != seal:
        raise FileError(path, "is not the file that this program wrote")
    fields = parse_fields(bytes(header), str(path))
    places = _find(path, fields.inner("arrays"), len(header), len(data))
    document = fields.inner("document")
    return ArrayFile(path, document, seal is not None, data, places)


def _read(path: Path) -> memoryview:
    """Reads the file into memory."""
    try:
        # Only regular files are read, since reading a pipe or a device may
        # never end.
        if not path.is_file() and path.exists():
            raise FileError(path, "is not a file")
        with path.open("rb") as file:
            size = os.fstat(file.fileno()).st_size
            data = np.empty(size, np.uint8).data
            if file.readinto(data) != size:
                raise FileError(
                    path, ("was changed by another program while it was read")
                )
            return data
    except OSError as error:
        raise FileError(path, error.strerror or str(error)) from error


def _map(path: Path) -> memoryview:
    """Maps the file into memory.

    The mapping is private and writable, since kernels are compiled for writable
    arrays. Writes to it do not change the file.
    """
    try:
        with path.open("rb") as file:
            return memoryview(
                mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_COPY)
            )
    except OSError as error:
        raise FileError(path, error.strerror or str(error)) from error
    except ValueError as error:  # An empty file cannot be mapped.
        raise FileError(path, "is empty") from error


def _header(path: Path, kind: FileKind, data: memoryview) -> memoryview:
    if len(data) < _PREFIX.size:
        raise FileError(path, f"is not a {kind.name}: it is too short")
    magic, version, size, end, digest = _PREFIX.unpack(data[: _PREFIX.size])
    if magic != kind.magic:
        raise FileError(path, f"is not a {kind.name} ({path.suffix})")
    if version != kind.version:
        raise VersionError(
            path,
            f"is a {kind.name} of format {version};"
            f" this program reads {kind.version}",
        )
    if len(data) != end:
        raise FileError(
            path, f"is truncated: it has {len(data)} bytes instead of {end}"
        )
    header = data[_PREFIX.size :][: min(size, _LONGEST_HEADER)]
    if hashlib.sha256(header).digest() != digest:
        raise FileError(path, "is damaged: the checksum of its header is wrong")
    return header


def _find(
    path: Path, entries: JsonFields, header: int, end: int
) -> dict[str, _Place]:
    """Finds the arrays in a file that ends at byte `end`."""
    places = {}
    offset = _aligned(_PREFIX.size + header)
    for name in entries.names():
        entry = entries.inner(name)
        dtype, shape = entry.text("dtype"), entry.wholes("shape")
        if dtype not in _TYPES:
            raise entry.error("dtype", f"expected one of {', '.join(_TYPES)}")
        if len(shape) > _MOST_DIMENSIONS:
            raise entry.error("shape", "has too many dimensions")
        # Dimensions of 0 count as 1, so that the other dimensions are bounded,
        # too.
        size = np.dtype(dtype).itemsize * math.prod(max(n, 1) for n in shape)
        if size > _LARGEST_ARRAY:
            raise entry.error("shape", "is too large")
        last = offset + (size if all(shape) else 0)
        crc32 = entry.whole("crc32")
        places[name] = _Place(dtype, shape, offset, last, crc32)
        offset = _aligned(last)
    if offset != end:
        raise FileError(
            path, f"is damaged: its arrays end at {offset} instead of {end}"
        )
    return places


def _aligned(size: int) -> int:
    return -(-size // _ALIGNMENT) * _ALIGNMENT
