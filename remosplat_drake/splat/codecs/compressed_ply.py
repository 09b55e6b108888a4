"""Reads and writes PlayCanvas' compressed PLY files.

Each splat has four words of 32 bits: position, scale, rotation and colour. The
components of position and scale have 11, 10 and 11 bits. They are fractions
between the bounds of a chunk of 256 splats. The rotation is stored as the three
smallest components of wxyz with 10 bits each. The colour channels and the
opacity have 8 bits each. Higher harmonics may follow in a table of bytes.
"""

from pathlib import Path

import numpy as np
from plyfile import PlyData, PlyElement

from remosplat_drake.base.atomic_file import atomic_write
from remosplat_drake.base.errors import FileError
from remosplat_drake.splat.activation import checked_splat, exponential
from remosplat_drake.splat.codecs.ply import read_ply_elements
from remosplat_drake.splat.codecs.quaternion_packing import (
    from_smallest_three,
    rounded,
    smallest_three,
)
from remosplat_drake.splat.codecs.unpacking import check_count
from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.splat.surfel_conversion import with_thickness

CHUNK = 256
"""Number of splats in a chunk. The splats of a chunk share their bounds."""

_WORDS = ("packed_position", "packed_rotation", "packed_scale", "packed_color")
_POSITION = ("x", "y", "z")
_SCALE = ("scale_x", "scale_y", "scale_z")
_COLOR = ("r", "g", "b")
_11_10_11 = ((21, 11), (11, 10), (0, 11))
_10_10_10 = ((20, 10), (10, 10), (0, 10))
_8_8_8 = ((24, 8), (16, 8), (8, 8))
_LOG_SCALE_LIMIT = 20.0
_HARMONIC_RANGE = 8.0


def read_compressed_ply(path: Path) -> GaussianSplat:
    """Reads a compressed PLY of PlayCanvas, with or without bounds of colour.

    Raises:
        FileError: The file is unreadable or truncated, is not a compressed PLY,
            declares counts that do not match, or contains an invalid value.
    """
    elements = read_ply_elements(path)
    for name in ("chunk", "vertex"):
        if name not in elements:
            raise FileError(
                path, f"is not a compressed splat: it has no element {name!r}"
            )
    bounds, words = elements["chunk"], elements["vertex"]
    n = len(words)
    check_count(path, n)
    if len(bounds) != -(-n // CHUNK):
        raise FileError(
            path,
            f"has {len(bounds)} chunks for {n} splats; expected"
            f" {-(-n // CHUNK)}",
        )
    position, rotation, scale, color = _columns(path, words, _WORDS, "u4").T
    fractions = _unpacked(color, _8_8_8)
    has_color_bounds = "min_r" in (bounds.dtype.names or ())
    three = (_unpacked(rotation, _10_10_10) - 0.5) * np.sqrt(2)
    return checked_splat(
        path,
        p_GK=_between(path, bounds, _POSITION, _unpacked(position, _11_10_11)),
        quaternions=from_smallest_three((rotation >> 30).astype(int), three),
        scales=exponential(
            _between(path, bounds, _SCALE, _unpacked(scale, _11_10_11))
        ),
        opacities=(color & 255) / 255,
        colors=_between(path, bounds, _COLOR, fractions)
        if has_color_bounds
        else fractions,
        sh_rest=_harmonics(path, elements.get("sh"), n),
    )


def write_compressed_ply(path: Path, splat: GaussianSplat) -> None:
    """Writes a compressed PLY of PlayCanvas, sorted by `morton_order`.

    In this order, the splats of a chunk are near each other in space, so the
    rounding steps are small. Discs become thin ellipsoids.

    Raises:
        FileError: The file cannot be written.
    """
    splat = with_thickness(splat).select(morton_order(splat.p_GK))
    log_scales = np.log(splat.scales.astype(float))
    log_scales = np.clip(log_scales, -_LOG_SCALE_LIMIT, _LOG_SCALE_LIMIT)
    bounds: dict[str, np.ndarray] = {}
    largest, three = smallest_three(splat.quaternions.astype(float))
    colors = _packed(_within(bounds, _COLOR, splat.colors), _8_8_8)
    words = [
        _packed(_within(bounds, _POSITION, splat.p_GK), _11_10_11),
        _packed(three / np.sqrt(2) + 0.5, _10_10_10)
        | (largest.astype(np.uint32) << 30),
        _packed(_within(bounds, _SCALE, log_scales), _11_10_11),
        colors | rounded(255 * splat.opacities, 255),
    ]
    names = [
        f"{end}_{name}"
        for group in (_POSITION, _SCALE, _COLOR)
        for end in ("min", "max")
        for name in group
    ]
    chunk = _table(names, [bounds[name] for name in names], "<f4")
    elements = {"chunk": chunk, "vertex": _table(_WORDS, words, "<u4")}
    rest = splat.sh_rest.transpose(0, 2, 1).reshape(len(splat), -1)
    if rest.shape[1]:
        steps = np.floor((rest / _HARMONIC_RANGE + 0.5) * 256)
        names = [f"f_rest_{i}" for i in range(rest.shape[1])]
        elements["sh"] = _table(names, rounded(steps, 255).T, "u1")
    document = PlyData(
        [PlyElement.describe(rows, name) for name, rows in elements.items()],
        byte_order="<",
    )
    with atomic_write(path, "wb") as stream:
        document.write(stream)


def morton_order(p_GK: np.ndarray) -> np.ndarray:
    """Sorts positions along a Morton curve (Z-order curve).

    Args:
        p_GK: Positions, shape (N, 3) [m].

    Returns:
        The indices of the positions in this order, shape (N,).
    """
    lower = p_GK.min(axis=0)
    extent = np.maximum(np.ptp(p_GK, axis=0), np.finfo(np.float32).tiny)
    cells = rounded(1023 * ((p_GK - lower) / extent), 1023)
    code = np.zeros(len(p_GK), np.uint32)
    for bit in range(10):
        for axis in range(3):
            code |= (cells[:, axis] >> bit & 1) << (3 * bit + axis)
    return np.argsort(code, kind="stable")


def _unpacked(words: np.ndarray, fields: tuple) -> np.ndarray:
    """Returns bit fields (shift, bits) of words as fractions in [0, 1]."""
    columns = [
        (words >> shift & (1 << bits) - 1) / ((1 << bits) - 1)
        for shift, bits in fields
    ]
    return np.stack(columns, axis=1)


def _packed(fractions: np.ndarray, fields: tuple) -> np.ndarray:
    words = np.zeros(len(fractions), np.uint32)
    for column, (shift, bits) in zip(fractions.T, fields, strict=True):
        most = (1 << bits) - 1
        words |= rounded(most * column, most) << shift
    return words


def _between(
    path: Path, bounds: np.ndarray, names: tuple, fractions: np.ndarray
) -> np.ndarray:
    """Converts fractions to values between the bounds of their chunks."""
    lower, upper = (
        _columns(path, bounds, [f"{end}_{name}" for name in names], "f4")
        .astype(float)
        .repeat(CHUNK, axis=0)[: len(fractions)]
        for end in ("min", "max")
    )
    return lower * (1 - fractions) + upper * fractions


def _within(
    bounds: dict[str, np.ndarray], names: tuple, values: np.ndarray
) -> np.ndarray:
    """Returns values as fractions between their chunks' bounds."""
    starts = np.arange(0, len(values), CHUNK)
    # The file contains the bounds in single precision, so the fractions are
    # computed with the rounded bounds.
    lower = np.minimum.reduceat(values, starts).astype(np.float32)
    upper = np.maximum.reduceat(values, starts).astype(np.float32)
    for i, name in enumerate(names):
        bounds[f"min_{name}"], bounds[f"max_{name}"] = lower[:, i], upper[:, i]
    lower, upper = (
        end.astype(float).repeat(CHUNK, axis=0)[: len(values)]
        for end in (lower, upper)
    )
    extent = np.maximum(upper - lower, np.finfo(np.float32).tiny)
    return np.clip((values - lower) / extent, 0, 1)


def _harmonics(path: Path, table: np.ndarray | None, n: int) -> np.ndarray:
    """Returns the higher harmonics, coefficient-major, shape (N, K, 3)."""
    if table is None:
        return np.zeros((n, 0, 3))
    if len(table) != n:
        raise FileError(
            path,
            f"has spherical harmonics of {len(table)} splats, but {n} splats",
        )
    count = len(table.dtype.names or ())
    if count not in (9, 24, 45, 72):
        raise FileError(
            path, f"{count} f_rest properties; expected 9, 24, 45 or 72"
        )
    names = [f"f_rest_{i}" for i in range(count)]
    steps = _columns(path, table, names, "u1")
    fractions = np.select(
        [steps == 0, steps == 255], [0, 1], (steps + 0.5) / 256
    )
    rest = ((fractions - 0.5) * _HARMONIC_RANGE).reshape(n, 3, count // 3)
    return rest.transpose(0, 2, 1)


def _columns(
    path: Path, table: np.ndarray, names: tuple | list, kind: str
) -> np.ndarray:
    """Returns named columns of one type, shape (rows, len(names))."""
    for name in names:
        if name not in (table.dtype.names or ()):
            raise FileError(path, f"property {name} is missing")
        dtype = table.dtype[name]
        if dtype.newbyteorder("=") != np.dtype(kind):
            raise FileError(
                path,
                f"property {name} has type {dtype.name}; expected"
                f" {np.dtype(kind).name}",
            )
    return np.stack([table[name] for name in names], axis=1).astype(kind)


def _table(names, columns, kind: str) -> np.ndarray:
    rows = np.empty(len(columns[0]), [(name, kind) for name in names])
    for name, column in zip(names, columns, strict=True):
        rows[name] = column
    return rows
