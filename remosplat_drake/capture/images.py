"""Reads the colour, depth and mask images of captures.

Files may be damaged or malicious. So an image's size is checked before its
pixels are unpacked, and all errors of decoders become a `FileError`.
"""

import struct
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from remosplat_drake.base.errors import FieldError, FileError, MissingExtraError

MAX_PIXELS = 50_000_000
"""An image is read only if it has at most this many pixels."""

Source = Path | zipfile.Path
"""Type of a file's path, in a folder or in a zip archive."""


def read_colors(source: Source) -> np.ndarray:
    """Reads the sRGB colours of an image file; ignores alpha.

    Returns:
        Shape (h, w, 3), uint8.

    Raises:
        FileError: The file is missing or damaged, or has no 8-bit colours.
        MissingExtraError: Pillow is not installed.
    """
    image = _read_image(source, "8-bit colours", ("RGB", "RGBA", "L", "P"))
    return np.asarray(image.convert("RGB"))


def read_depth(source: Source, unit: float) -> np.ndarray:
    """Reads depth from a 16-bit or float image, or an OpenEXR or .npy file.

    Args:
        source: The file.
        unit: Length that the number 1 in the file stands for [m].

    Returns:
        Shape (h, w), float32 [m]; 0 where the file has no finite number.

    Raises:
        FileError: The file is missing or damaged, or is not a depth image.
        MissingExtraError: Pillow or OpenEXR is not installed.
    """
    if source.name.endswith(".npy"):
        steps = _read_array(source)
    elif source.name.endswith(".exr"):
        steps = _read_exr(source)
    else:
        modes = ("I;16", "I;16B", "I", "F")
        steps = np.asarray(_read_image(source, "16-bit or float depth", modes))
    # Integers are multiplied in double precision, so that 2429 mm become the
    # float32 that is nearest to 2.429.
    with np.errstate(over="ignore", invalid="ignore"):
        depth = (steps * float(unit)).astype(np.float32)
    return np.where(np.isfinite(depth), depth, np.float32(0))


def read_levels(source: Source) -> np.ndarray:
    """Reads the numbers 0..255 of a mask or confidence image, shape (h, w)."""
    return np.asarray(_read_image(source).convert("L"))


def read_size(source: Source) -> tuple[int, int]:
    """Reads the height and width of an image file, but not its pixels.

    Raises:
        FileError: The file is missing, damaged or too large.
        MissingExtraError: Pillow is not installed.
    """
    with _opened(source) as image:
        width, height = image.size
    return height, width


def shrink_colors(rgb: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Shrinks an image (h, w, 3) by averaging over areas.

    Args:
        rgb: Colours, shape (h, w, 3), uint8.
        size: Height and width of the result [pixels].
    """
    if rgb.shape[:2] == size:
        return rgb
    image = image_module()
    height, width = size
    return np.asarray(
        image.fromarray(rgb).resize((width, height), image.Resampling.BOX)
    )


def check_pixel_count(source: Source, width: int, height: int):
    """Checks the size of an image before memory is allocated for it.

    Raises:
        FileError: The image has more than `MAX_PIXELS` pixels.
    """
    if width * height > MAX_PIXELS:
        raise FileError(
            str(source),
            f"has {width}x{height} pixels; at most {MAX_PIXELS / 1e6:.0f} "
            "million are read",
        )


def check_announced_size(where: str, field: str, width: float, height: float):
    """Checks the size of an image as a field of a file states it.

    This check is for images whose own files do not contain their size.

    Raises:
        FieldError: The size is out of range; the error names `where` and
            `field`.
    """
    if not (width >= 1 and height >= 1 and width * height <= MAX_PIXELS):
        raise FieldError(
            where,
            field,
            f"the image must have 1 to {MAX_PIXELS} pixels",
        )


def image_module() -> ModuleType:
    """Imports Pillow's `Image` module.

    Raises:
        MissingExtraError: Pillow is not installed.
    """
    try:
        from PIL import Image
    except ImportError as error:
        raise MissingExtraError("RGB-D images", "reconstruction") from error
    return Image


def _read_image(
    source: Source, expected: str = "", modes: tuple[str, ...] = ()
):
    """A decoded Pillow image; `modes` limits the valid modes."""
    with _opened(source) as image:
        if modes and image.mode not in modes:
            raise FileError(
                str(source), f"expected {expected}, got mode {image.mode}"
            )
        image.load()
        return image


@contextmanager
def _opened(source: Source) -> Iterator[Any]:
    """A Pillow image whose header has been read and checked."""
    image = image_module()
    try:
        with source.open("rb") as file, image.open(file) as opened:
            check_pixel_count(source, *opened.size)
            yield opened
    except FileNotFoundError as error:
        raise FileError(str(source), "no such file") from error
    except (
        OSError,
        SyntaxError,  # Pillow's, for a PNG file with damaged blocks.
        ValueError,
        EOFError,
        struct.error,
        zipfile.BadZipFile,
        image.DecompressionBombError,
    ) as error:
        raise FileError(str(source), f"unreadable image: {error}") from error


def _read_array(source: Source) -> np.ndarray:
    """A two-dimensional array of numbers from a .npy file."""
    try:
        # Memory mapping makes NumPy compare the header's size with the file's
        # size.
        array = np.load(str(source), mmap_mode="r", allow_pickle=False)
    except FileNotFoundError as error:
        raise FileError(str(source), "no such file") from error
    except (OSError, ValueError, EOFError) as error:
        raise FileError(str(source), f"unreadable array: {error}") from error
    if array.ndim != 2 or not array.size or array.dtype.kind not in "fiu":
        raise FileError(
            str(source),
            f"expected a depth image, got {array.dtype} of shape {array.shape}",
        )
    return np.array(array)


def _read_exr(source: Source) -> np.ndarray:
    """The first channel of an OpenEXR file."""
    try:
        import OpenEXR
    except ImportError as error:
        raise MissingExtraError(
            "depth in OpenEXR files", "reconstruction"
        ) from error
    path = Path(str(source))
    if not path.is_file():
        raise FileError(path, "no such file")
    try:
        with OpenEXR.File(str(path), header_only=True) as file:
            low, high = file.header()["dataWindow"]
        check_pixel_count(source, *(high - low + 1).tolist())
        with OpenEXR.File(str(path)) as file:
            pixels = next(iter(file.channels().values())).pixels
    except (RuntimeError, ValueError, TypeError, StopIteration) as error:
        raise FileError(path, f"unreadable OpenEXR file: {error}") from error
    return pixels if pixels.ndim == 2 else pixels[..., 0]
