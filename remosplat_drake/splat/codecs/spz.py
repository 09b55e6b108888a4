"""Reads and writes Niantic's SPZ format, versions 1 to 4.

A file consists of a header and six sections of quantised values. Up to version
3, the file is one gzipped stream. In version 4, each section is a zstandard
stream. The axes of SPZ are right, up, back, and those of PLY files are right,
down, front. So this module changes the signs of y and z.
"""

from pathlib import Path

import numpy as np

from remosplat_drake.base.errors import FileError
from remosplat_drake.splat.activation import checked_splat
from remosplat_drake.splat.codecs.quaternion_packing import (
    from_smallest_three,
    rounded,
    smallest_three,
)
from remosplat_drake.splat.codecs.spz_container import (
    SpzHeader,
    degree_of,
    read_sections,
    write_sections,
)
from remosplat_drake.splat.gaussian_splat import SH_C0, GaussianSplat
from remosplat_drake.splat.surfel_conversion import with_thickness

AXIS_SIGNS = np.array([1.0, -1.0, -1.0])
"""Signs that convert between right-up-back and right-down-front axes."""

QUATERNION_SIGNS = np.array([1.0, -1.0, -1.0, 1.0])
"""Signs of quaternions xyzw after the change of axes."""

HARMONICS_SIGNS = np.array(
    # -1 for each harmonic of degrees 1 to 4 that changes its sign if y and z
    # change their signs.
    [
        *(-1, -1, 1),
        *(-1, 1, 1, -1, 1),
        *(-1, 1, -1, -1, 1, -1, 1),
        *(-1, 1, -1, 1, 1, -1, 1, -1, 1),
    ]
)
"""Signs of the higher harmonics' coefficients after the change of axes."""

COLOR_RANGE = 0.15
"""Scale of colours: the bytes represent f_dc from -0.5 / 0.15 to 0.5 / 0.15."""

_SIGN_BIT = 1 << 9
_MAGNITUDE = _SIGN_BIT - 1


def read_spz(path: Path) -> GaussianSplat:
    """Reads an SPZ file of version 1 to 4; its splats have three scales.

    Raises:
        FileError: The file is unreadable, not an SPZ file, damaged or
            truncated, or it would unpack to more than it declares or than fits
            into memory.
        MissingExtraError: Version 4 needs the package zstandard.
    """
    header, sections = read_sections(path)
    positions, alphas, colors, scales, rotations, harmonics = sections
    n = header.count
    f_dc = (_bytes(colors, n) / 255 - 0.5) / COLOR_RANGE
    rest = (_bytes(harmonics, n).reshape(n, -1, 3) - 128) / 128
    xyzw = _unpack_rotations(rotations, header) * QUATERNION_SIGNS
    return checked_splat(
        path,
        p_GK=_unpack_positions(positions, header) * AXIS_SIGNS,
        quaternions=np.roll(xyzw, 1, axis=1),
        scales=np.exp(_bytes(scales, n) / 16 - 10),
        opacities=_bytes(alphas, n)[:, 0] / 255,
        colors=0.5 + SH_C0 * f_dc,
        sh_rest=rest * HARMONICS_SIGNS[: rest.shape[1], None],
    )


def write_spz(path: Path, splat: GaussianSplat, version: int = 3) -> None:
    """Writes an SPZ file; discs become thin ellipsoids.

    Args:
        path: The file to write or replace.
        splat: The splat.
        version: Version of the format: 3, which needs no optional package, or
            4.

    Raises:
        FileError: The file cannot be written, or a splat is too far away for
            the format, or has too many harmonics.
        MissingExtraError: Version 4 needs the package zstandard.
        ValueError: The version is neither 3 nor 4.
    """
    if version not in (3, 4):
        raise ValueError(f"{version=} is not 3 or 4")
    harmonics = splat.sh_rest.shape[1]
    degree = degree_of(harmonics)
    if degree is None:
        raise FileError(path, f"SPZ cannot hold {harmonics} higher harmonics")
    splat = with_thickness(splat)
    header = SpzHeader(version, len(splat), degree)
    f_dc = (splat.colors.astype(float) - 0.5) / SH_C0
    rest = splat.sh_rest * HARMONICS_SIGNS[:harmonics, None]
    values = [
        rounded(255 * splat.opacities, 255),
        rounded(255 * (COLOR_RANGE * f_dc + 0.5), 255),
        rounded(16 * (np.log(splat.scales.astype(float)) + 10), 255),
    ]
    sections = [
        _pack_positions(path, splat, header),
        *(value.astype(np.uint8).tobytes() for value in values),
        _pack_rotations(splat),
        rounded(128 * rest + 128, 255).astype(np.uint8).tobytes(),
    ]
    write_sections(path, header, sections)


def _bytes(section: bytes, n: int) -> np.ndarray:
    return np.frombuffer(section, np.uint8).reshape(n, -1).astype(float)


def _unpack_positions(section: bytes, header: SpzHeader) -> np.ndarray:
    """Returns positions in right-up-back axes, shape (N, 3) [m]."""
    if header.version == 1:
        return np.frombuffer(section, "<f2").reshape(-1, 3).astype(float)
    # A coordinate has three bytes. A zero byte below them gives a signed 32-bit
    # integer, and the shift to the right preserves its sign.
    padded = np.zeros((header.count, 3, 4), np.uint8)
    padded[..., 1:] = np.frombuffer(section, np.uint8).reshape(-1, 3, 3)
    fixed = padded.view("<i4")[..., 0] >> 8
    return fixed / 2.0**header.fractional_bits


def _unpack_rotations(section: bytes, header: SpzHeader) -> np.ndarray:
    """Returns unit quaternions xyzw in right-up-back axes, shape (N, 4)."""
    if header.version < 3:
        xyz = _bytes(section, header.count) / 127.5 - 1
        w = np.sqrt(np.maximum(1 - np.sum(xyz**2, axis=1), 0))
        return np.column_stack([xyz, w])
    packed = np.frombuffer(section, "<u4")
    fields = np.stack([packed >> 20, packed >> 10, packed], axis=1)
    magnitude = (fields & _MAGNITUDE) * (np.sqrt(0.5) / _MAGNITUDE)
    three = np.where(fields & _SIGN_BIT, -magnitude, magnitude)
    return from_smallest_three((packed >> 30).astype(int), three)


def _pack_positions(
    path: Path, splat: GaussianSplat, header: SpzHeader
) -> bytes:
    steps = 2.0**header.fractional_bits
    fixed = np.rint(splat.p_GK * AXIS_SIGNS * steps)
    far = np.abs(fixed).max(axis=1) >= 2**23
    if far.any():
        raise FileError(
            path,
            f"splat {far.argmax()} is farther away than SPZ can represent,"
            f" {2**23 / steps:.0f} m ({far.sum()} such splats)",
        )
    words = np.ascontiguousarray(fixed, "<i4").view(np.uint8)
    return words.reshape(-1, 4)[:, :3].tobytes()


def _pack_rotations(splat: GaussianSplat) -> bytes:
    xyzw = np.roll(splat.quaternions.astype(float), -1, axis=1)
    largest, three = smallest_three(xyzw * QUATERNION_SIGNS)
    fields = rounded(np.abs(three) * (_MAGNITUDE * np.sqrt(2)), _MAGNITUDE)
    fields |= np.where(three < 0, _SIGN_BIT, 0).astype(np.uint32)
    packed = fields @ np.array([1 << 20, 1 << 10, 1], np.uint32)
    packed |= largest.astype(np.uint32) << 30
    return packed.astype("<u4").tobytes()
