"""Reads and writes PLY files of splats: INRIA's 3DGS, 2DGS and variants.

The PLY file of a splat contains raw network parameters: log scales, logits of
opacities, quaternions wxyz of any length, and coefficients of spherical
harmonics. This module converts these parameters to the activated values that
all other modules use.
"""

import dataclasses as dc
import math
import re
import textwrap
from pathlib import Path
from typing import IO

import numpy as np
from plyfile import PlyData, PlyParseError

from remosplat_drake.base.atomic_file import atomic_write
from remosplat_drake.base.errors import FileError
from remosplat_drake.base.threads import blocks
from remosplat_drake.splat.activation import (
    checked_splat,
    exponential,
    logit,
    sigmoid,
)
from remosplat_drake.splat.blocks import in_blocks
from remosplat_drake.splat.gaussian_splat import SH_C0, GaussianSplat

_BLOCK = 4096
_LONGEST_HEADER = 2**16
_ELEMENT = re.compile(rb"^element[ \t]+(\S+)[ \t]+([-+]?\d+)\s*$", re.M)
_LIST = re.compile(rb"^property[ \t]+list\b[^\n]*?(\S+)\s*$", re.M)
_POSITION = ("x", "y", "z")
_NORMAL = ("nx", "ny", "nz")
_COLOR = ("f_dc_0", "f_dc_1", "f_dc_2")
_OPACITY = ("opacity",)
_ROTATION = ("rot_0", "rot_1", "rot_2", "rot_3")
_UNCERTAINTY = ("uncertainty",)


def read_ply(path: str | Path, harmonics: bool = True) -> GaussianSplat:
    """Reads a 2DGS (two scales) or 3DGS (three scales) splat from a PLY file.

    The properties may have any order, with or without normals and higher
    harmonics. The file may be binary, with either byte order, or ASCII, which
    is slow. Scales and opacities that underflow are raised to the smallest
    normal float. The property `uncertainty` [m], an extension of this package,
    is optional.

    Args:
        path: The file.
        harmonics: Whether the higher harmonics are returned; if not, they are
            only checked.

    Raises:
        FileError: The file is missing, truncated or empty, is not a PLY file
            with splats, or contains an invalid value; the error names the row.
    """
    path = Path(path)
    vertices = _read_vertices(path)
    names = vertices.dtype.names or ()
    scales = _numbered(path, names, "scale_")
    if len(scales) > 3:
        raise FileError(path, f"{len(scales)} scales per splat; valid: 2 or 3")
    rest = _numbered(path, names, "f_rest_")
    bands = math.isqrt(len(rest) // 3 + 1)
    if len(rest) != 3 * (bands**2 - 1):
        raise FileError(
            path,
            f"{len(rest)} f_rest properties; expected 0, 9, 24, 45 or 72",
        )
    scales = scales if len(scales) > 1 else ("scale_0", "scale_1")
    required = (*_POSITION, *_COLOR, *_OPACITY, *scales, *_ROTATION)
    missing = [name for name in required if name not in names]
    if missing:
        raise FileError(
            path,
            "is not a Gaussian splat: property"
            f" {', '.join(missing)} is missing",
        )
    layout = _Layout(scales, rest, harmonics, _UNCERTAINTY[0] in names)
    arrays = in_blocks(
        len(vertices),
        lambda rows: _activated(
            path, _read(path, vertices, rows), layout
        ).arrays(),
    )
    return GaussianSplat.restored(arrays)


@dc.dataclass(frozen=True)
class _Layout:
    """The properties of a file that are optional or vary in number.

    Attributes:
        scales: Names of the scales.
        rest: Names of the higher harmonics' coefficients.
        keeps_rest: Whether the higher harmonics are returned.
        has_uncertainty: Whether the file has the property `uncertainty`.
    """

    scales: tuple[str, ...]
    rest: tuple[str, ...]
    keeps_rest: bool
    has_uncertainty: bool


def _activated(
    path: Path, vertices: np.ndarray, layout: _Layout
) -> GaussianSplat:
    """Returns the activated values of some rows."""
    # f_rest is channel-major: first all coefficients of red, then those of
    # green, then those of blue.
    harmonics = _columns(path, vertices, layout.rest).reshape(
        len(vertices), 3, len(layout.rest) // 3
    )
    if not layout.keeps_rest:
        harmonics = harmonics[:, :, :0]
    uncertainty = None
    if layout.has_uncertainty:
        uncertainty = _columns(path, vertices, _UNCERTAINTY)[:, 0]
    return checked_splat(
        path,
        p_GK=_columns(path, vertices, _POSITION),
        quaternions=_columns(path, vertices, _ROTATION),
        scales=exponential(_columns(path, vertices, layout.scales)),
        opacities=sigmoid(_columns(path, vertices, _OPACITY)[:, 0]),
        colors=0.5 + SH_C0 * _columns(path, vertices, _COLOR),
        sh_rest=harmonics.transpose(0, 2, 1),
        uncertainty=uncertainty,
    )


def write_ply(
    path: str | Path, splat: GaussianSplat, with_normals: bool = True
) -> None:
    """Writes a splat in INRIA's property order, binary little-endian.

    The file is written completely or not at all. A surfel splat keeps its two
    scales, as in the 2DGS reference code. If the uncertainty is known, it is
    the last property, which other programs ignore.

    Args:
        path: The file to write or replace.
        splat: The splat; opacities of 1 are stored as the nearest finite logit.
        with_normals: Whether the columns nx, ny and nz are written, which some
            viewers expect. They are zero, as in INRIA's files.

    Raises:
        FileError: The file cannot be written.
    """
    columns = _raw(splat.select(slice(0, 0)), with_normals)
    names = [name for block in columns for name in block]
    header = [
        "ply",
        "format binary_little_endian 1.0",
        f"element vertex {len(splat)}",
        *(f"property float {name}" for name in names),
        "end_header\n",
    ]
    with atomic_write(Path(path), "wb") as stream:
        stream.write("\n".join(header).encode())
        for rows in blocks(len(splat), _BLOCK):
            columns = _raw(splat.select(rows), with_normals)
            table = np.concatenate(list(columns.values()), axis=1)
            stream.write(table.astype("<f4").data)


def _raw(
    splat: GaussianSplat, with_normals: bool
) -> dict[tuple[str, ...], np.ndarray]:
    """Returns raw parameters of splats, keyed by column, in INRIA's order."""
    n = len(splat)
    harmonics = splat.sh_rest.transpose(0, 2, 1)
    rest = harmonics.reshape(n, 3 * splat.sh_rest.shape[1])
    columns = {
        _POSITION: splat.p_GK,
        _NORMAL: np.zeros((n, 3)),
        _COLOR: (splat.colors - 0.5) / SH_C0,
        tuple(f"f_rest_{i}" for i in range(rest.shape[1])): rest,
        _OPACITY: logit(splat.opacities)[:, None],
        ("scale_0", "scale_1", "scale_2")[: splat.scales.shape[1]]: np.log(
            splat.scales
        ),
        _ROTATION: splat.quaternions,
    }
    if splat.uncertainty is not None:
        columns[_UNCERTAINTY] = splat.uncertainty[:, None]
    if not with_normals:
        del columns[_NORMAL]
    return columns


def read_ply_elements(path: Path) -> dict[str, np.ndarray]:
    """Reads the tables of a PLY file, keyed by the names of its elements.

    Raises:
        FileError: The file is missing or truncated, is not a PLY file, contains
            more than its header declares, or has a property that is a list.
    """
    try:
        _check_header(path)
        # If a value of a text file overflows, a later check finds that it is
        # not finite.
        with _open_ply(path) as stream, np.errstate(over="ignore"):
            document = PlyData.read(stream)
            trailing = bool(stream.read().strip())
    except MemoryError as error:
        raise FileError(
            path, "declares more rows than fit into memory"
        ) from error
    except (OSError, PlyParseError, ValueError) as error:
        problem = textwrap.shorten(str(error), 120)
        raise FileError(path, f"unreadable as PLY: {problem}") from error
    if trailing:
        count = document.elements[-1].count if document.elements else 0
        raise FileError(
            path, f"holds more data than the {count} rows it declares"
        )
    return {element.name: element.data for element in document.elements}


def _check_header(path: Path) -> None:
    """Checks the sizes in the header before memory is allocated.

    If there is no header, the package plyfile reports the error later.
    """
    with path.open("rb") as stream:
        header = stream.read(_LONGEST_HEADER).partition(b"end_header")[0]
    largest = path.stat().st_size
    for element, count in _ELEMENT.findall(header):
        # A row takes at least one byte.
        if not 0 <= float(count) <= largest:
            name = element.decode("ascii", "replace")
            problem = f"declares {count.decode()} rows of {name}"
            raise FileError(path, textwrap.shorten(problem, 120))
    listed = _LIST.search(header)
    if listed is not None:
        name = listed[1].decode("ascii", "replace")
        raise FileError(path, f"property {name} is a list, not a number")


def _read_vertices(path: Path) -> np.ndarray:
    """Returns the rows of the file's vertex element."""
    elements = read_ply_elements(path)
    if "vertex" not in elements:
        raise FileError(path, "no splats: the PLY has no element 'vertex'")
    if not len(elements["vertex"]):
        raise FileError(path, "holds no splats")
    return elements["vertex"]


def _read(path: Path, vertices: np.ndarray, rows: slice) -> np.ndarray:
    """Returns some rows of the file's vertices.

    If the vertices are memory-mapped, the rows are read from the file instead
    of the mapping. Otherwise the accessed pages would stay in memory, and
    finally the whole file.
    """
    if not isinstance(vertices, np.memmap):
        return vertices[rows]
    dtype, start = vertices.dtype, rows.start * vertices.dtype.itemsize
    count = min(rows.stop, len(vertices)) - rows.start
    return np.fromfile(path, dtype, count, offset=vertices.offset + start)


def _open_ply(path: Path) -> IO:
    """Opens the file as text or binary."""
    with path.open("rb") as stream:
        is_text = b"format ascii" in stream.read(64)
    return path.open(encoding="ascii") if is_text else path.open("rb")


def _numbered(
    path: Path, names: tuple[str, ...], prefix: str
) -> tuple[str, ...]:
    """Returns the properties prefix0, prefix1, ..., without a gap."""
    pattern = re.compile(re.escape(prefix) + r"\d+")
    count = sum(bool(pattern.fullmatch(name)) for name in names)
    numbered = tuple(f"{prefix}{i}" for i in range(count))
    for name in numbered:
        if name not in names:
            raise FileError(path, f"property {name} is missing")
    return numbered


def _columns(
    path: Path, vertices: np.ndarray, names: tuple[str, ...]
) -> np.ndarray:
    """Returns columns as an (N, len(names)) float32 table of finite numbers."""
    for name in names:
        dtype = vertices.dtype[name]
        if dtype.kind != "f":
            raise FileError(
                path, f"property {name} has type {dtype.name}; expected float"
            )
    table = _adjacent(vertices, names)
    if table is None:
        table = np.empty((len(vertices), len(names)), np.float32)
        # Columns are copied block by block, so that the rows of a block stay in
        # the cache.
        for start in range(0, len(table), _BLOCK):
            rows = slice(start, start + _BLOCK)
            block = vertices[rows]
            for column, name in enumerate(names):
                table[rows, column] = block[name]
    bad = ~np.isfinite(table)
    if bad.any():
        row, column = np.argwhere(bad)[0]
        raise FileError(path, f"row {row}: {names[column]} is not finite")
    return table


def _adjacent(
    vertices: np.ndarray, names: tuple[str, ...]
) -> np.ndarray | None:
    """Returns adjacent columns of rows of floats as a view; None for others."""
    fields = vertices.dtype.fields or {}
    places = {name: place for name, (_, place, *_) in fields.items()}
    floats = all(vertices.dtype[name] == np.float32 for name in places)
    if not names or not floats or vertices.dtype.itemsize != 4 * len(places):
        return None
    first = places[names[0]] // 4
    if [places[name] for name in names] != [
        4 * (first + i) for i in range(len(names))
    ]:
        return None
    rows = np.asarray(vertices).view(np.float32).reshape(len(vertices), -1)
    return rows[:, first : first + len(names)].copy()
