"""Reads and writes the sections of SPZ files: gzip or zstandard streams.

Files of versions 1 to 3 are gzipped as a whole. Files of version 4 have a table
of zstandard streams. Sizes are checked before any data are unpacked.
"""

import dataclasses as dc
import struct
import zlib
from pathlib import Path

from remosplat_drake.base.atomic_file import write_atomically
from remosplat_drake.base.errors import FileError, MissingExtraError
from remosplat_drake.splat.codecs.unpacking import (
    check_count,
    check_unpacked_size,
    gunzip_at_most,
    read_whole,
)

GZIP_MAGIC = b"\x1f\x8b"
SPZ_MAGIC = b"NGSP"

_COMMON = struct.Struct("<4sIIBBBB")
_TABLE_OFFSET = struct.Struct("<I12x")
_TABLE_ENTRY = struct.Struct("<QQ")
_HAS_EXTENSIONS = 2
_MAX_WINDOW = 2**27  # Memory that zstandard may take besides [bytes].
_HARMONICS = (0, 3, 8, 15, 24)
"""Number of coefficients per colour channel for each degree, without the
constant coefficient."""


@dc.dataclass(frozen=True)
class SpzHeader:
    """The 16 bytes of the header that all versions of SPZ share.

    Attributes:
        version: Version of the format, 1 to 4.
        count: Number of splats.
        degree: Degree of the spherical harmonics, 0 to 4.
        fractional_bits: Number of fractional bits of the fixed-point positions.
        flags: Bit flags: 1 if the splat was trained with anti-aliasing, and 2
            if extensions follow.
        num_streams: Number of zstandard streams in version 4; reserved in other
            versions.
    """

    version: int
    count: int
    degree: int
    fractional_bits: int = 12
    flags: int = 0
    num_streams: int = 0

    @property
    def section_sizes(self) -> tuple[int, ...]:
        """Sizes of the six unpacked sections [bytes].

        The sections are positions, alphas, colours, scales, rotations and
        harmonics, in this order.
        """
        position = 6 if self.version == 1 else 9
        rotation = 3 if self.version < 3 else 4
        rest = 3 * _HARMONICS[self.degree]
        each = (position, 1, 3, 3, rotation, rest)
        return tuple(self.count * size for size in each)


def degree_of(harmonics: int) -> int | None:
    """Returns the spherical-harmonics degree of a number of coefficients.

    Args:
        harmonics: Number of coefficients of higher harmonics per colour
            channel.

    Returns:
        The degree; None if there is no such degree in SPZ.
    """
    return _HARMONICS.index(harmonics) if harmonics in _HARMONICS else None


def read_sections(path: Path) -> tuple[SpzHeader, list[bytes]]:
    """Reads the header and the six unpacked sections of an SPZ file.

    Raises:
        FileError: The file is unreadable, not an SPZ file, damaged or
            truncated, or its unpacked size differs from the size that its
            header declares.
        MissingExtraError: Version 4 needs the package zstandard.
    """
    data = read_whole(path)
    if data.startswith(GZIP_MAGIC):
        start = gunzip_at_most(path, data, _COMMON.size)
        header = _parse_header(path, start, versions=(1, 2, 3))
        return header, _gunzip_sections(path, data, header)
    if data.startswith(SPZ_MAGIC):
        header = _parse_header(path, data, versions=(4,))
        return header, _unpack_streams(path, data, header)
    raise FileError(
        path, "not an SPZ file: neither gzipped nor starting with NGSP"
    )


def _parse_header(
    path: Path, data: bytes, versions: tuple[int, ...]
) -> SpzHeader:
    if len(data) < _COMMON.size:
        raise FileError(path, "truncated: it ends within the header")
    magic, *fields = _COMMON.unpack_from(data)
    if magic != SPZ_MAGIC:
        raise FileError(path, "not an SPZ file: gzipped, but without splats")
    header = SpzHeader(*fields)
    if header.version not in versions:
        raise FileError(
            path,
            f"unknown SPZ version {header.version}; valid: 1, 2, 3 (gzipped)"
            " and 4 (not gzipped)",
        )
    if header.degree >= len(_HARMONICS):
        raise FileError(
            path, f"has harmonics of degree {header.degree}; valid: 0 to 4"
        )
    if header.fractional_bits > 23:
        raise FileError(
            path,
            f"has positions with {header.fractional_bits} fractional bits;"
            " valid: 0 to 23",
        )
    check_count(path, header.count)
    return header


def _gunzip_sections(path: Path, data: bytes, header: SpzHeader) -> list[bytes]:
    size = sum(header.section_sizes)
    check_unpacked_size(path, len(data), size)
    whole = _COMMON.size + size
    # The reader requests one byte more than declared, so that zlib reaches the
    # end and verifies the checksum.
    unpacked = gunzip_at_most(path, data, whole + 1)
    if len(unpacked) < whole:
        raise FileError(
            path,
            f"declares {header.count} splats, which need {whole} bytes, but"
            f" holds {len(unpacked)} bytes",
        )
    if len(unpacked) > whole and not header.flags & _HAS_EXTENSIONS:
        raise FileError(
            path, f"holds more than the {header.count} splats that it declares"
        )
    sections, start = [], _COMMON.size
    for length in header.section_sizes:
        sections.append(unpacked[start : start + length])
        start += length
    return sections


def _unpack_streams(path: Path, data: bytes, header: SpzHeader) -> list[bytes]:
    used = [size for size in header.section_sizes if size]
    if header.num_streams != len(used):
        raise FileError(
            path, f"has {header.num_streams} streams; expected {len(used)}"
        )
    first = _COMMON.size + _TABLE_OFFSET.size
    if len(data) < first:
        raise FileError(path, "truncated: it ends within the header")
    (table,) = _TABLE_OFFSET.unpack_from(data, _COMMON.size)
    start = table + len(used) * _TABLE_ENTRY.size
    if table < first or start > len(data):
        raise FileError(path, "its table of streams lies outside the file")
    sections = []
    for size in used:
        packed, unpacked = _TABLE_ENTRY.unpack_from(data, table)
        table += _TABLE_ENTRY.size
        if unpacked != size:
            raise FileError(
                path,
                f"declares a stream of {unpacked} bytes; {header.count}"
                f" splats need {size}",
            )
        if packed > len(data) - start:
            raise FileError(path, "truncated: a stream ends beyond the file")
        stream = data[start : start + packed]
        sections.append(_unpack_stream(path, stream, size))
        start += packed
    # Only the last section, the harmonics, may have no stream.
    return sections + [b""] * (len(header.section_sizes) - len(sections))


def _unpack_stream(path: Path, stream: bytes, size: int) -> bytes:
    """Returns a stream's content, which must have the declared size."""
    zstandard = _zstandard()
    check_unpacked_size(path, len(stream), size)
    unpacker = zstandard.ZstdDecompressor(max_window_size=_MAX_WINDOW)
    try:
        section = unpacker.stream_reader(stream).read(size + 1)
    except zstandard.ZstdError as error:
        raise FileError(path, f"damaged: {error}") from error
    if len(section) != size:
        raise FileError(path, "damaged: a stream is not of its declared size")
    return section


def write_sections(
    path: Path, header: SpzHeader, sections: list[bytes]
) -> None:
    """Writes an SPZ file from a header and its six sections.

    Raises:
        FileError: The file cannot be written.
        MissingExtraError: Version 4 needs the package zstandard.
    """
    if header.version < 4:
        stream = zlib.compressobj(6, wbits=16 + zlib.MAX_WBITS)
        content = _packed_header(header) + b"".join(sections)
        write_atomically(path, stream.compress(content) + stream.flush())
        return
    compressor = _zstandard().ZstdCompressor(level=12)
    sections = [section for section in sections if section]
    streams = [compressor.compress(section) for section in sections]
    header = dc.replace(header, num_streams=len(streams))
    table = [
        _TABLE_ENTRY.pack(len(stream), len(section))
        for stream, section in zip(streams, sections, strict=True)
    ]
    offset = _TABLE_OFFSET.pack(_COMMON.size + _TABLE_OFFSET.size)
    write_atomically(
        path, b"".join([_packed_header(header), offset, *table, *streams])
    )


def _packed_header(header: SpzHeader) -> bytes:
    return _COMMON.pack(SPZ_MAGIC, *dc.astuple(header))


def _zstandard():
    try:
        import zstandard
    except ImportError as error:
        raise MissingExtraError("SPZ of version 4", "formats") from error
    return zstandard
