"""Reads and writes PlayCanvas' SOG: a splat as lossless WebP pictures.

The pictures are in a folder or in a zip archive. Pixel i of each picture
belongs to splat i. Positions have 16 bits per axis on a logarithmic scale.
Rotations are stored as the three smallest components of wxyz. Scales and
colours are bytes, which are indices into a codebook.
"""

from pathlib import Path

import numpy as np

from remosplat_drake.base.atomic_file import write_atomically
from remosplat_drake.base.errors import FileError
from remosplat_drake.splat.activation import checked_splat, exponential
from remosplat_drake.splat.codecs.quaternion_packing import (
    from_smallest_three,
    rounded,
    smallest_three,
)
from remosplat_drake.splat.codecs.sog_bundle import SogBundle, pack_bundle
from remosplat_drake.splat.gaussian_splat import SH_C0, GaussianSplat
from remosplat_drake.splat.surfel_conversion import with_thickness

VERSION = 2
"""Version of the format that is read and written."""
PALETTE_WIDTH = 64
"""Number of palette entries in a row of the picture of higher harmonics."""

_ROTATION_MARK = 252
_LARGEST_16 = 2**16 - 1
_BANDS = {1: 3, 2: 8, 3: 15}


def read_sog(path: Path) -> GaussianSplat:
    """Reads a `.sog` file, a folder of SOG, or the folder's meta.json.

    Raises:
        FileError: The bundle is unreadable, damaged or truncated, has another
            version, or has pictures whose sizes do not fit the number of
            splats.
        MissingExtraError: The pictures need Pillow.
    """
    bundle = SogBundle(path, VERSION)
    low, high = bundle.pictures("means", 2)
    lower = bundle.numbers("means.mins", 3)
    upper = bundle.numbers("means.maxs", 3)
    steps = low[:, :3].astype(float) + 256.0 * high[:, :3]
    logarithms = lower + (upper - lower) * (steps / _LARGEST_16)
    (packed,) = bundle.pictures("quats", 1)
    largest = packed[:, 3].astype(int) - _ROTATION_MARK
    if largest.min() < 0:
        raise FileError(path, f"splat {largest.argmin()} has no rotation")
    three = (packed[:, :3] / 255 * 2 - 1) * np.sqrt(0.5)
    (scales,) = bundle.pictures("scales", 1)
    (colors,) = bundle.pictures("sh0", 1)
    f_dc = bundle.codebook("sh0")[colors[:, :3]]
    return checked_splat(
        path,
        p_GK=_unlogarithm(logarithms),
        quaternions=from_smallest_three(largest, three),
        scales=exponential(bundle.codebook("scales")[scales[:, :3]]),
        opacities=colors[:, 3] / 255,
        colors=0.5 + SH_C0 * f_dc,
        sh_rest=_harmonics(path, bundle),
    )


def write_sog(path: Path, splat: GaussianSplat) -> None:
    """Writes a zipped `.sog`; discs become thin ellipsoids.

    Higher harmonics are omitted: they would need a palette made by clustering,
    and distances do not depend on them.

    Raises:
        FileError: The file cannot be written.
        MissingExtraError: The pictures need Pillow.
    """
    splat = with_thickness(splat)
    p_GK = splat.p_GK.astype(float)
    logarithms = np.sign(p_GK) * np.log1p(np.abs(p_GK))
    lower, upper = logarithms.min(axis=0), logarithms.max(axis=0)
    extent = np.maximum(upper - lower, np.finfo(np.float32).tiny)
    steps = rounded(_LARGEST_16 * (logarithms - lower) / extent, _LARGEST_16)
    largest, three = smallest_three(splat.quaternions.astype(float))
    scale_book, scales = _quantized(np.log(splat.scales.astype(float)))
    color_book, colors = _quantized((splat.colors.astype(float) - 0.5) / SH_C0)
    opaque = np.full(len(splat), 255)
    alpha = rounded(255 * splat.opacities, 255)
    bundle = pack_bundle(
        path,
        meta={
            "version": VERSION,
            "asset": {"generator": "remosplat-drake"},
            "count": len(splat),
            "means": {"mins": lower.tolist(), "maxs": upper.tolist()},
            "scales": {"codebook": scale_book.tolist()},
            "quats": {},
            "sh0": {"codebook": color_book.tolist()},
        },
        pictures={
            "means": {
                "means_l": np.column_stack([steps & 255, opaque]),
                "means_u": np.column_stack([steps >> 8, opaque]),
            },
            "scales": {"scales": np.column_stack([scales, opaque])},
            "quats": {
                "quats": np.column_stack(
                    [
                        rounded(255 * (three / np.sqrt(2) + 0.5), 255),
                        largest + _ROTATION_MARK,
                    ]
                )
            },
            "sh0": {"sh0": np.column_stack([colors, alpha])},
        },
    )
    write_atomically(path, bundle)


def _unlogarithm(values: np.ndarray) -> np.ndarray:
    with np.errstate(over="ignore"):
        return np.sign(values) * np.expm1(np.abs(values))


def _quantized(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Returns a codebook of 256 numbers, and the index of each value in it.

    Lloyd's algorithm minimises the mean square error, starting from evenly
    spaced numbers.
    """
    book = np.linspace(values.min(), values.max(), 256)
    flat = np.sort(values, axis=None)
    total = np.concatenate([[0.0], np.cumsum(flat)])
    for _ in range(20):
        borders = np.searchsorted(flat, (book[1:] + book[:-1]) / 2)
        edges = np.concatenate([[0], borders, [len(flat)]])
        count = np.diff(edges)
        mean = np.diff(total[edges]) / np.maximum(count, 1)
        book[count > 0] = mean[count > 0]
    index = np.searchsorted((book[1:] + book[:-1]) / 2, values)
    return book, index


def _harmonics(path: Path, bundle: SogBundle) -> np.ndarray:
    """Returns the higher harmonics, coefficient-major, shape (N, K, 3)."""
    if not bundle.has("shN"):
        return np.zeros((bundle.count, 0, 3))
    entries = bundle.integer("shN.count")
    k = _BANDS.get(bundle.integer("shN.bands"))
    if k is None or not 1 <= entries <= _LARGEST_16 + 1:
        raise FileError(
            path,
            "higher harmonics (shN): expected 1 to 3 bands and 1 to 65536"
            " palette entries",
        )
    rows = -(-entries // PALETTE_WIDTH)
    centroids, labels = bundle.palette("shN", PALETTE_WIDTH * k, rows)
    label = labels[:, 0].astype(int) + 256 * labels[:, 1].astype(int)
    if label.max() >= entries:
        raise FileError(
            path, f"splat {label.argmax()} is not in the palette of shN"
        )
    palette = bundle.codebook("shN")[centroids[..., :3]]
    # A row of the picture contains 64 entries of k pixels each.
    return palette.reshape(-1, k, 3)[label]
