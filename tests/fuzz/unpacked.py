"""The size to which a file unpacks by its own header."""

import io
import struct
import zipfile
import zlib

from remosplat_drake.capture.readers import lzfse_data

MOST = 2 * 10**8
"""Memory that no reader exceeds for one file, for any content [bytes]."""

_PNG = b"\x89PNG\r\n\x1a\n"
_PIXEL = 4


def unpacked_size(data: bytes) -> int:
    """Bytes that a file's compressed parts unpack to; 0 if it has none."""
    return min(MOST, _unpacked_size(data))


def _unpacked_size(data: bytes) -> int:
    if data.startswith(_PNG) and len(data) >= 24:
        width, height = struct.unpack_from(">II", data, 16)
        return _PIXEL * width * height
    if data[:4] == b"RIFF" and data[8:12] == b"WEBP":
        return _PIXEL * _webp_pixels(data)
    if data.startswith(b"\x1f\x8b"):
        stream = zlib.decompressobj(wbits=16 + zlib.MAX_WBITS)
        try:
            return len(stream.decompress(data, MOST))
        except zlib.error:
            return 0
    if data.startswith(b"PK\x03\x04"):
        return _zip_size(data)
    if data.startswith(b"bvx"):
        try:
            return lzfse_data.unpacked_size(data)
        except (ValueError, struct.error):
            return 0
    return 0


def _zip_size(data: bytes) -> int:
    total = 0
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            for member in archive.infolist():
                total += member.file_size
                if member.file_size < 2**24:
                    total += _unpacked_size(archive.read(member))
    except Exception:  # Damaged in one of many ways: nothing comes of it.
        return total
    return total


def _webp_pixels(data: bytes) -> int:
    """Pixels of a lossless picture, whose header packs its sides."""
    if data[12:16] != b"VP8L" or len(data) < 25:
        return 0
    (packed,) = struct.unpack_from("<I", data, 21)
    return ((packed & 0x3FFF) + 1) * ((packed >> 14 & 0x3FFF) + 1)
