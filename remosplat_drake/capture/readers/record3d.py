"""Reads captures of the Record3D app: .r3d archives and EXR exports.

`metadata` (JSON) contains the intrinsics of the colour images: column by column
in `K` or, in newer files, for each frame in `perFrameIntrinsicCoeffs` (fx, fy,
cx, cy). It also contains poses `qx qy qz qw tx ty tz` of OpenGL cameras.
`rgbd/N.jpg` is the colour image. `rgbd/N.depth` contains float32 metres, and
`rgbd/N.conf` ARKit's confidence; both are packed with LZFSE. Files are read
from the archive one by one, and are not unpacked to disk. The reader also
accepts a folder with the unpacked files.

The app's "EXR + JPG" export is a folder with the same metadata in
`metadata.json`, with colour images `rgb/N.jpg`, and with depths in metres in
`depth/N.exr`.

According to the app's author, the world frame is that of the first camera, in
any orientation. Unlike ARKit's world frame, it is not aligned with gravity.
"""

import dataclasses as dc
import zipfile
import zlib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from remosplat_drake.base.errors import FieldError, FileError
from remosplat_drake.base.strict_json import as_number
from remosplat_drake.capture.frames import Frame, scale_intrinsics
from remosplat_drake.capture.images import (
    Source,
    check_announced_size,
    read_colors,
    read_depth,
)
from remosplat_drake.capture.readers.arkit import keep_confident
from remosplat_drake.capture.readers.image_lists import note_left_out
from remosplat_drake.capture.readers.lzfse_data import MAX_BYTES, unpack
from remosplat_drake.capture.readers.poses import (
    OPENGL_FROM_OPENCV,
    poses_from_quaternions,
)
from remosplat_drake.capture.readers.text_files import as_matrix, read_json
from remosplat_drake.capture.recording import DepthImage, Recording

SUFFIX = ".r3d"
"""Suffix of the app's archives."""
MAX_MEMBER_BYTES = 64_000_000
"""A file in an archive may have at most this size [bytes]."""

MAX_RATE = 1000.0
"""A capture may have at most this frame rate [1/s]."""

EXPECTED_FILES = (
    f"an {SUFFIX} file, or a folder with metadata and rgbd/, or with"
    " metadata.json, rgb/ and depth/"
)
"""Description of the files that `recognises` accepts."""


@dc.dataclass(frozen=True)
class _Layout:
    """Paths of the files; {} stands for the frame's number."""

    metadata: str
    color: str
    depth: str
    confidence: str | None

    def found_in(self, folder: Path) -> bool:
        return (folder / self.metadata).is_file() and all(
            (folder / name).parent.is_dir() for name in (self.color, self.depth)
        )


_ARCHIVE = _Layout("metadata", "rgbd/{}.jpg", "rgbd/{}.depth", "rgbd/{}.conf")
_EXPORT = _Layout("metadata.json", "rgb/{}.jpg", "depth/{}.exr", None)


def recognises(path: Path) -> bool:
    """Returns whether a path is a Record3D archive or an export's folder."""
    if path.is_dir():
        return any(layout.found_in(path) for layout in (_ARCHIVE, _EXPORT))
    return path.suffix.lower() == SUFFIX


def open_recording(path: Path) -> Recording:
    """Reads the metadata of a capture.

    Raises:
        FileError: A file is missing, unreadable or too large.
        FieldError: A field of the metadata is unusable.
        MissingExtraError: lzfse or OpenEXR is not installed.
    """
    with _opened(path) as (root, layout):
        metadata_path = root / layout.metadata
        where = str(metadata_path)
        metadata = read_json(metadata_path)
        size = _size(where, metadata, "h", "w")
        X_WC = _poses(where, metadata)
        K = _intrinsics(where, metadata, len(X_WC))
        times = _times(where, metadata, len(X_WC))

    def read_depths(
        chosen: Sequence[int],
    ) -> Iterator[tuple[int, DepthImage]]:
        with _opened(path) as (root, layout):
            for i in chosen:
                name = layout.color.format(i)
                depth = _read_depth(root, layout, i, metadata)
                yield i, DepthImage.of_color_camera(name, K[i], size, depth)

    def read_frames(chosen: Sequence[int]) -> Iterator[tuple[int, Frame]]:
        with _opened(path) as (root, layout):
            for i in chosen:
                name = layout.color.format(i)
                rgb = read_colors(root / name)
                yield (
                    i,
                    Frame(
                        name=name,
                        K=scale_intrinsics(K[i], size, rgb.shape[:2]),
                        X_WC=X_WC[i],
                        rgb=rgb,
                        depth=_read_depth(root, layout, i, metadata),
                        time=None if times is None else float(times[i]),
                    ),
                )

    return Recording(X_WC, read_depths, read_frames, times)


@contextmanager
def _opened(path: Path) -> Iterator[tuple[Source, _Layout]]:
    """Opens a capture; returns the root of its files, and their layout."""
    if path.is_dir():
        yield path, _EXPORT if _EXPORT.found_in(path) else _ARCHIVE
        return
    try:
        with zipfile.ZipFile(path) as archive:
            _check_members(path, archive)
            yield zipfile.Path(archive), _ARCHIVE
    except (
        OSError,
        zipfile.BadZipFile,
        zlib.error,
        NotImplementedError,  # An unknown kind of packing.
    ) as error:
        raise FileError(path, f"unreadable archive: {error}") from error


def notes(path: Path) -> list[str]:
    """Returns notes on unused data of a capture; does not read frames."""
    with _opened(path) as (root, layout):
        count = len(_poses(layout.metadata, read_json(root / layout.metadata)))
        folder, pattern = layout.color.split("/")
        suffix = pattern.removeprefix("{}")
        stems = [
            file.name.removesuffix(suffix)
            for file in (root / folder).iterdir()
            if file.name.endswith(suffix)
        ]
    numbers = sorted(int(stem) for stem in stems if stem.isdecimal())
    names = [layout.color.format(number) for number in numbers]
    used = {layout.color.format(i) for i in range(count)}
    return note_left_out(names, used, "a pose")


def _check_members(path: Path, archive: zipfile.ZipFile):
    """Rejects an archive whose header declares a file as too large."""
    for member in archive.infolist():
        if member.file_size > MAX_MEMBER_BYTES:
            raise FileError(
                path,
                f"{member.filename} has {member.file_size / 1e6:.0f} MB; at "
                f"most {MAX_MEMBER_BYTES / 1e6:.0f} MB are read",
            )
        if member.flag_bits & 1:
            raise FileError(path, f"{member.filename} is encrypted")


def _size(where: str, metadata: dict, *keys: str) -> tuple[int, int]:
    """Height and width from two fields of the metadata."""
    height, width = (as_number(where, k, metadata.get(k)) for k in keys)
    check_announced_size(where, ", ".join(keys), width, height)
    return int(height), int(width)


def _poses(where: str, metadata: dict) -> np.ndarray:
    """X_WC in OpenCV axes, (n, 4, 4)."""
    rows = _table(where, metadata, "poses", 7)
    try:
        X_WC_gl = poses_from_quaternions(rows[:, :4], rows[:, 4:])
    except ValueError as error:
        raise FieldError(where, "poses", str(error)) from error
    # By columns, so that values that are not finite do not affect others.
    return X_WC_gl * OPENGL_FROM_OPENCV.diagonal()


def _intrinsics(where: str, metadata: dict, count: int) -> np.ndarray:
    """K of the colour images, (n, 3, 3)."""
    if metadata.get("perFrameIntrinsicCoeffs"):
        rows = _table(where, metadata, "perFrameIntrinsicCoeffs", 4)
        if len(rows) != count:
            raise FieldError(
                where,
                "perFrameIntrinsicCoeffs",
                f"expected {count} rows, got {len(rows)}",
            )
        K = np.tile(np.eye(3), (count, 1, 1))
        K[:, [0, 1, 0, 1], [0, 1, 2, 2]] = rows
        return K
    columns = as_matrix(Path(where), [metadata.get("K")], (1, 9))
    return np.tile(columns.reshape(3, 3).T, (count, 1, 1))


def _times(where: str, metadata: dict, count: int) -> np.ndarray | None:
    """Times of the frames, (n,) [s]; older files contain only the frame rate.

    None if the metadata contain neither.
    """
    times = metadata.get("frameTimestamps")
    if times:
        if not isinstance(times, list) or len(times) != count:
            problem = f"expected {count} times"
            raise FieldError(where, "frameTimestamps", problem)
        return as_matrix(Path(where), [times], (1, count))[0]
    if "fps" not in metadata:
        return None
    rate = as_number(where, "fps", metadata["fps"])
    if not 0 < rate <= MAX_RATE:
        problem = f"must be from 0 to {MAX_RATE:g}"
        raise FieldError(where, "fps", problem)
    return np.arange(count) / rate


def _table(where: str, metadata: dict, key: str, width: int) -> np.ndarray:
    rows = metadata.get(key)
    if not isinstance(rows, list) or not rows:
        raise FieldError(where, key, "expected a list of rows")
    try:
        return as_matrix(Path(where), rows, (len(rows), width))
    except FileError as error:
        raise FieldError(where, key, error.problem) from error


def _read_depth(
    root: Source, layout: _Layout, frame: int, metadata: dict
) -> np.ndarray:
    """Depth [m], (h, w); 0 where unknown or of low confidence."""
    source = root / layout.depth.format(frame)
    if layout.confidence is None:
        return read_depth(source, unit=1.0)
    depth = _unpack_depth(source, str(root / layout.metadata), metadata)
    confidence = root / layout.confidence.format(frame)
    if not confidence.exists():
        return depth
    levels = np.frombuffer(unpack(confidence, depth.size), np.uint8)
    return keep_confident(confidence, depth, levels)


def _unpack_depth(source: Source, where: str, metadata: dict) -> np.ndarray:
    size = None
    if "dw" in metadata and "dh" in metadata:
        size = _size(where, metadata, "dh", "dw")
    # One byte more, so that the error can state that the data are too long.
    most = MAX_BYTES if size is None else 4 * size[0] * size[1] + 1
    data = unpack(source, most)
    count = len(data) // 4
    if size is not None:
        height, width = size
    else:
        # Older files do not contain the depth's size; its aspect ratio is the
        # colour's.
        color_height, color_width = _size(where, metadata, "h", "w")
        height = round((count * color_height / color_width) ** 0.5)
        width = count // max(height, 1)
    if len(data) != 4 * height * width or count == 0:
        raise FileError(
            str(source),
            f"expected {width}x{height} float32 depths, got {len(data)} bytes",
        )
    depth = np.frombuffer(data, "<f4").reshape(height, width)
    return np.where(np.isfinite(depth), depth, np.float32(0))
