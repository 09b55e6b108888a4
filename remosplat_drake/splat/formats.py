"""Defines the formats of splat files, with their readers and writers."""

import dataclasses as dc
import zipfile
from collections.abc import Callable
from pathlib import Path

from remosplat_drake.base import resources
from remosplat_drake.base.errors import FileError
from remosplat_drake.base.reading import reads_file
from remosplat_drake.splat.codecs.antimatter import (
    read_antimatter,
    write_antimatter,
)
from remosplat_drake.splat.codecs.checkpoint import (
    is_checkpoint_archive,
    read_checkpoint,
    write_checkpoint,
)
from remosplat_drake.splat.codecs.compressed_ply import (
    morton_order,
    read_compressed_ply,
    write_compressed_ply,
)
from remosplat_drake.splat.codecs.ply import read_ply, write_ply
from remosplat_drake.splat.codecs.sog import read_sog, write_sog
from remosplat_drake.splat.codecs.sog_bundle import META, ZIP_MAGIC
from remosplat_drake.splat.codecs.spz import read_spz, write_spz
from remosplat_drake.splat.codecs.spz_container import GZIP_MAGIC, SPZ_MAGIC
from remosplat_drake.splat.codecs.unpacking import ZIP_DAMAGES
from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.splat.surfel_conversion import is_flat, without_thickness

_LONGEST_PLY_HEADER = 2**16


@dc.dataclass(frozen=True)
class SplatFormat:
    """A file format of Gaussian splats.

    Attributes:
        title: Display name of the format.
        suffix: Suffix of the names of files of this format.
        read: Function that reads a file.
        write: Function that writes a file, completely or not at all.
        loss: Sentence about the information that is lost when a splat is
            written; empty if values are only rounded to single precision.
        keeps_surfels: Whether the format supports 2DGS discs, which have two
            scales. If not, discs are written as ellipsoids that all have the
            same tiny thickness, by which they are recognised.
        keeps_uncertainty: Whether the format supports the splats' uncertainty.
            If not, the uncertainty is lost.
        reorders: Whether splats are written in `morton_order`.
    """

    title: str
    suffix: str
    read: Callable[[Path], GaussianSplat]
    write: Callable[[Path, GaussianSplat], None]
    loss: str = ""
    keeps_surfels: bool = False
    keeps_uncertainty: bool = False
    reorders: bool = False

    def as_written(self, splat: GaussianSplat) -> GaussianSplat:
        """Returns a splat in the order in which this format writes it."""
        if not self.reorders:
            return splat
        return splat.select(morton_order(splat.p_GK))


PLY = SplatFormat(
    "PLY",
    ".ply",
    read_ply,
    write_ply,
    keeps_surfels=True,
    keeps_uncertainty=True,
)
"""The PLY format of INRIA's 3DGS and of 2DGS."""
CHECKPOINT = SplatFormat(
    "gsplat checkpoint", ".pt", read_checkpoint, write_checkpoint
)
"""Checkpoints of gsplat's trainers (torch)."""
ANTIMATTER = SplatFormat(
    ".splat",
    ".splat",
    read_antimatter,
    write_antimatter,
    loss="Rotations, colours and opacities are rounded to 8 bits; higher"
    " harmonics are lost.",
)
"""The `.splat` format of antimatter15's viewer."""
SPZ = SplatFormat(
    "SPZ",
    ".spz",
    read_spz,
    write_spz,
    loss="Positions have steps of 0.24 mm, scales steps of 6 % and a minimum of"
    " 45 um; rotations are rounded to 10 bits, and colours and opacities to 8"
    " bits.",
)
"""Niantic's SPZ."""
COMPRESSED_PLY = SplatFormat(
    "compressed PLY",
    ".compressed.ply",
    read_compressed_ply,
    write_compressed_ply,
    loss="Positions and scales are rounded to 10 or 11 bits between the"
    " bounds of 256 neighbours, rotations to 10 bits, and colours and"
    " opacities to 8 bits; the splats are reordered.",
    reorders=True,
)
"""PlayCanvas' compressed PLY."""
SOG = SplatFormat(
    "SOG",
    ".sog",
    read_sog,
    write_sog,
    loss="Positions are rounded to 16 bits of their logarithm, rotations and"
    " opacities to 8 bits, scales and colours to one of 256 values each;"
    " higher harmonics are lost.",
)
"""PlayCanvas' SOG."""

FORMATS = (COMPRESSED_PLY, PLY, CHECKPOINT, ANTIMATTER, SPZ, SOG)
"""All formats, those with the longer suffix first."""


@reads_file
def read_splat(
    path: str | Path, surfel: bool | None = None, *, harmonics: bool = True
) -> GaussianSplat:
    """Reads a Gaussian splat of any format.

    The format is recognised by the file's content, or else by its name. Formats
    without 2DGS discs store discs as ellipsoids that all have the same tiny
    thickness. These are read as discs again (`is_flat`).

    Args:
        path: A file, a folder of PlayCanvas' SOG, or a `package://` URI.
        surfel: Whether a checkpoint contains 2DGS discs. If it is None,
            `read_checkpoint` detects it.
        harmonics: Whether the higher harmonics are returned. Distances and the
            drawings of this library do not need them, and a PLY file is read
            faster without them.

    Raises:
        FileError: The file is missing, has an unknown format, is damaged, or
            contains an invalid value.
        MissingExtraError: The format needs a package that is not installed.

    Example:
        >>> import remosplat_drake as rs
        >>> uri = "package://remosplat_drake/models/scenes/table/splat.ply"
        >>> len(rs.read_splat(uri)) > 10_000
        True
    """
    path = resources.expand(path)
    chosen = format_of_file(path)
    if chosen is CHECKPOINT:
        splat = read_checkpoint(path, surfel)
    elif chosen is PLY:
        splat = _with_discs(read_ply(path, harmonics))
    else:
        splat = _with_discs(chosen.read(path))
    return splat if harmonics else splat.without_harmonics()


def _with_discs(splat: GaussianSplat) -> GaussianSplat:
    return without_thickness(splat) if is_flat(splat) else splat


def write_splat(path: str | Path, splat: GaussianSplat) -> None:
    """Writes a splat in the format of the file's suffix.

    Raises:
        FileError: The suffix belongs to no format, or the file cannot be
            written.
        MissingExtraError: The format needs a package that is not installed.
    """
    format_of_name(Path(path)).write(Path(path), splat)


def format_of_name(path: Path) -> SplatFormat:
    """Returns the format of a file name's suffix.

    Raises:
        FileError: The suffix belongs to no format.
    """
    chosen = _format_by_suffix(path)
    if chosen is None:
        raise FileError(path, f"unknown suffix; {_valid()}")
    return chosen


def format_of_file(path: Path) -> SplatFormat:
    """Returns the format of a file by its first bytes, or else by its name.

    Raises:
        FileError: The file is unreadable, or of no known format.
    """
    folder = path.parent if path.name == META else path
    if folder.is_dir():
        if not (folder / META).is_file():
            raise FileError(path, f"a folder without {META} is not an SOG")
        return SOG
    try:
        with path.open("rb") as stream:
            start = stream.read(_LONGEST_PLY_HEADER)
    except OSError as error:
        raise FileError(path, error.strerror or str(error)) from error
    if start.startswith(b"ply"):
        header = start.partition(b"end_header")[0]
        return COMPRESSED_PLY if b"element chunk" in header else PLY
    if start.startswith((GZIP_MAGIC, SPZ_MAGIC)):
        return SPZ
    chosen = _format_of_zip(path, start) or _format_by_suffix(path)
    if chosen is None:
        raise FileError(path, f"not a known format of splats; {_valid()}")
    return chosen


def _format_of_zip(path: Path, start: bytes) -> SplatFormat | None:
    if not start.startswith(ZIP_MAGIC):
        return None
    try:
        with zipfile.ZipFile(path) as archive:
            names = archive.namelist()
    except ZIP_DAMAGES:
        return None
    if META in names:
        return SOG
    return CHECKPOINT if is_checkpoint_archive(names) else None


def _format_by_suffix(path: Path) -> SplatFormat | None:
    name = path.name.lower()
    return next((f for f in FORMATS if name.endswith(f.suffix)), None)


def _valid() -> str:
    return f"valid: {', '.join(sorted(f.suffix for f in FORMATS))}"
