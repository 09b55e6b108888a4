"""Reads and writes the `.splat` format of antimatter15's viewer.

A file consists of rows of 32 bytes, without a header. A row contains the
position and the linear scales as float32, and RGBA and the quaternion wxyz as
bytes.
"""

from pathlib import Path

import numpy as np

from remosplat_drake.base.atomic_file import write_atomically
from remosplat_drake.base.errors import FileError
from remosplat_drake.splat.activation import checked_splat
from remosplat_drake.splat.codecs.quaternion_packing import rounded
from remosplat_drake.splat.codecs.unpacking import check_count, read_whole
from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.splat.surfel_conversion import with_thickness

_ROW = np.dtype(
    [
        ("p_GK", "<f4", 3),
        ("scales", "<f4", 3),
        ("rgba", "u1", 4),
        ("quaternion", "u1", 4),
    ]
)


def read_antimatter(path: Path) -> GaussianSplat:
    """Reads a `.splat` file, which always contains three scales.

    Raises:
        FileError: The file is unreadable or truncated, or contains an invalid
            value. The format has no magic number.
    """
    data = read_whole(path)
    if len(data) % _ROW.itemsize:
        raise FileError(
            path,
            f"not a .splat, or truncated: {len(data)} bytes are not a "
            f"multiple of {_ROW.itemsize}",
        )
    rows = np.frombuffer(data, _ROW)
    check_count(path, len(rows))
    rgba = rows["rgba"] / 255
    return checked_splat(
        path,
        p_GK=rows["p_GK"],
        quaternions=(rows["quaternion"].astype(np.float64) - 128) / 128,
        scales=rows["scales"],
        opacities=rgba[:, 3],
        colors=rgba[:, :3],
        sh_rest=np.zeros((len(rows), 0, 3)),
    )


def write_antimatter(path: Path, splat: GaussianSplat) -> None:
    """Writes a `.splat` file; discs become thin ellipsoids.

    Raises:
        FileError: The file cannot be written.
    """
    splat = with_thickness(splat)
    rows = np.empty(len(splat), _ROW)
    rows["p_GK"] = splat.p_GK
    rows["scales"] = splat.scales
    rows["rgba"][:, :3] = rounded(255 * splat.colors, 255)
    rows["rgba"][:, 3] = rounded(255 * splat.opacities, 255)
    rows["quaternion"] = rounded(128 * splat.quaternions + 128, 255)
    write_atomically(path, rows.tobytes())
