"""Reads and checks the files of a SOG bundle: meta.json and its pictures.

Before a picture is decoded, its sizes are checked: the size of the zip entry,
and the width and height that the picture's header declares.
"""

import io
import json
import math
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from remosplat_drake.base.errors import FileError, MissingExtraError
from remosplat_drake.base.strict_json import parse_json_object, shown
from remosplat_drake.splat.codecs.unpacking import (
    ZIP_DAMAGES,
    check_count,
    check_unpacked_size,
    read_whole,
)

META = "meta.json"
ZIP_MAGIC = b"PK\x03\x04"

_MAX_META = 2**24
_MAX_PICTURE = 2**28


class SogBundle:
    """A SOG bundle, whose parts are read from its zip or folder on demand."""

    def __init__(self, path: Path, version: int):
        """Opens the bundle and reads its meta.json.

        Args:
            path: A `.sog` zip, a folder, or the folder's meta.json.
            version: The version that the bundle's meta.json must have.

        Raises:
            FileError: There is no bundle at this path, or it has another
                version.
        """
        self._path = path
        self._folder = path.parent if path.name == META else path
        self._zip = None
        if not self._folder.is_dir():
            try:
                self._zip = zipfile.ZipFile(io.BytesIO(read_whole(path)))
            except ZIP_DAMAGES as error:
                raise FileError(path, f"not an SOG file: {error}") from error
        self._meta = parse_json_object(
            self._read(META, _MAX_META), self._folder / META
        )
        if self._meta.get("version") != version:
            raise FileError(
                path,
                f"has SOG version {shown(self._meta.get('version'))}; this"
                f" program reads version {version}",
            )
        self.count = self.integer("count")
        check_count(path, self.count)

    def has(self, part: str) -> bool:
        """Returns whether the bundle contains an optional part."""
        return part in self._meta

    def integer(self, field: str) -> int:
        """Returns a whole number of meta.json by its dotted path.

        Raises:
            FileError: The field is missing, or is not a whole number.
        """
        value = self._field(field)
        if not isinstance(value, int) or isinstance(value, bool):
            raise FileError(
                self._path, f"{META}: {field} is not a whole number"
            )
        return value

    def numbers(self, field: str, n: int) -> np.ndarray:
        """Returns a list of n finite numbers of meta.json by its dotted path.

        Raises:
            FileError: The field is missing, or is not a list of n finite
                numbers.
        """
        values = self._field(field)
        try:
            numbers = np.array(values, float)
        except (TypeError, ValueError):
            numbers = np.empty(0)
        if numbers.shape != (n,) or not np.isfinite(numbers).all():
            raise FileError(
                self._path,
                f"{META}: {field} is not a list of {n} finite numbers",
            )
        return numbers

    def codebook(self, part: str) -> np.ndarray:
        """Returns a part's codebook: a number for each byte value."""
        return self.numbers(f"{part}.codebook", 256)

    def pictures(self, part: str, n: int) -> list[np.ndarray]:
        """Returns a part's n pictures, each as rows RGBA, one row per splat."""
        return [self._splats(name) for name in self._names(part, n)]

    def palette(
        self, part: str, width: int, rows: int
    ) -> tuple[np.ndarray, np.ndarray]:
        """Returns a part's palette (rows, width, 4) and labels (count, 4)."""
        centroids, labels = self._names(part, 2)
        pixels = self._pixels(centroids, width * rows)
        if pixels.shape[1] != width or len(pixels) < rows:
            raise FileError(
                self._path,
                f"{centroids} is {pixels.shape[1]} x {len(pixels)} pixels;"
                f" expected {width} x {rows}",
            )
        return pixels[:rows], self._splats(labels)

    def _field(self, field: str) -> Any:
        value = self._meta
        for name in field.split("."):
            if not isinstance(value, dict) or name not in value:
                raise FileError(self._path, f"{META}: {field} is missing")
            value = value[name]
        return value

    def _names(self, part: str, n: int) -> list[str]:
        names = self._field(f"{part}.files")
        if (
            not isinstance(names, list)
            or len(names) != n
            or not all(isinstance(x, str) and Path(x).name == x for x in names)
        ):
            raise FileError(
                self._path, f"{META}: {part}.files is not a list of {n} names"
            )
        return names

    def _read(self, name: str, limit: int = _MAX_PICTURE) -> bytes:
        if self._zip is None:
            path = self._folder / name
            if path.is_file():
                self._check_limit(name, path.stat().st_size, limit)
            return read_whole(path)
        try:
            entry = self._zip.getinfo(name)
        except KeyError as error:
            raise FileError(self._path, f"{name} is missing") from error
        self._check_limit(name, entry.file_size, limit)
        check_unpacked_size(self._path, entry.compress_size, entry.file_size)
        try:
            return self._zip.read(entry)
        except ZIP_DAMAGES as error:
            raise FileError(
                self._path, f"{name} is damaged: {error}"
            ) from error

    def _check_limit(self, name: str, size: int, limit: int) -> None:
        if size > limit:
            raise FileError(
                self._path, f"{name} has {size} bytes; at most {limit}"
            )

    def _splats(self, name: str) -> np.ndarray:
        pixels = self._pixels(name, self.count).reshape(-1, 4)
        if len(pixels) < self.count:
            raise FileError(
                self._path,
                f"{name} has {len(pixels)} pixels for {self.count} splats",
            )
        return pixels[: self.count]

    def _pixels(self, name: str, needed: int) -> np.ndarray:
        """Returns a picture's RGBA bytes, shape (height, width, 4)."""
        image_module = _pillow()
        data = self._read(name)
        try:
            with image_module.open(io.BytesIO(data), formats=["WEBP"]) as image:
                width, height = image.size
                # Programs that write SOG pad rows and tiles of pictures, but by
                # less than a factor of two.
                if width * height > 2 * needed + 2**16:
                    raise FileError(
                        self._path,
                        f"{name} has {width} x {height} pixels, but {needed}"
                        " are needed",
                    )
                check_unpacked_size(self._path, len(data), 4 * width * height)
                return np.asarray(image.convert("RGBA"))
        except (
            OSError,
            SyntaxError,
            ValueError,
            image_module.DecompressionBombError,
        ) as error:
            raise FileError(
                self._path, f"{name} is not a WebP picture, or damaged"
            ) from error


def pack_bundle(
    path: Path,
    meta: dict[str, Any],
    pictures: Mapping[str, Mapping[str, np.ndarray]],
) -> bytes:
    """Packs meta.json and pictures into a SOG zip archive.

    Args:
        path: The file to which the archive will be written, for errors.
        meta: Content of meta.json, to which the names of the files are added.
        pictures: The pictures of each part, keyed by part and by name, as rows
            of shape (count, 4) with values from 0 to 255.

    Returns:
        The bytes of the archive.

    Raises:
        FileError: There are no splats.
        MissingExtraError: The pictures need Pillow.
    """
    check_count(path, meta["count"])
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_STORED) as archive:
        for part, images in pictures.items():
            names = [f"{name}.webp" for name in images]
            meta[part]["files"] = names
            for name, rows in zip(names, images.values(), strict=True):
                # ZipInfo has a fixed date by default, so equal splats give
                # equal files.
                archive.writestr(zipfile.ZipInfo(name), _webp(rows))
        archive.writestr(zipfile.ZipInfo(META), json.dumps(meta))
    return content.getvalue()


def _webp(rows: np.ndarray) -> bytes:
    width = 4 * math.ceil(math.sqrt(len(rows)) / 4)
    height = -(-len(rows) // width)
    pixels = np.zeros((height * width, 4), np.uint8)
    pixels[: len(rows)] = rows
    image = _pillow().fromarray(pixels.reshape(height, width, 4), "RGBA")
    content = io.BytesIO()
    # `exact` preserves the colours of pixels whose alpha is zero, since all
    # four channels contain data.
    image.save(content, "WEBP", lossless=True, exact=True, quality=50)
    return content.getvalue()


def _pillow():
    try:
        from PIL import Image
    except ImportError as error:
        raise MissingExtraError("SOG", "formats") from error
    return Image
