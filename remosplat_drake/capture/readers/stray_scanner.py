"""Reads captures of the Stray Scanner app.

`rgb.mp4` is the colour video. `depth/NNNNNN.png` contain depths in millimetres,
and `confidence/NNNNNN.png` ARKit's levels of confidence. `odometry.csv` has a
row for each frame: time, number, position, quaternion and, in newer versions,
the intrinsics for images of the video's size (`fx, fy, cx, cy`). In older
versions, `camera_matrix.csv` contains the intrinsics of all frames. Poses have
OpenCV axes and are in ARKit's world frame, whose y axis points up.
"""

import csv
from collections.abc import Collection, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from remosplat_drake.base.errors import FileError, MissingExtraError
from remosplat_drake.capture.frames import Frame
from remosplat_drake.capture.images import (
    check_pixel_count,
    read_depth,
    read_levels,
)
from remosplat_drake.capture.readers.arkit import keep_confident
from remosplat_drake.capture.readers.image_lists import (
    images_in,
    note_left_out,
)
from remosplat_drake.capture.readers.poses import poses_from_quaternions
from remosplat_drake.capture.readers.text_files import read_matrix, read_text
from remosplat_drake.capture.recording import DepthImage, Recording

DEPTH_UNIT = 1e-3
"""Length of one step of a depth image [m]."""

VIDEO = "rgb.mp4"
"""Name of the colour video."""
ODOMETRY = "odometry.csv"
"""Name of the table of camera poses."""
UP_W = (0.0, 1.0, 0.0)
"""Unit vector opposite to gravity: the y axis of ARKit's world frame."""

EXPECTED_FILES = f"a folder with {VIDEO} and {ODOMETRY}"
"""Description of the files that `recognises` accepts."""

_POSE = ("x", "y", "z", "qx", "qy", "qz", "qw")
_CAMERA = ("fx", "fy", "cx", "cy")


def recognises(path: Path) -> bool:
    """Returns whether a path is a folder of the Stray Scanner app."""
    return (path / VIDEO).is_file() and (path / ODOMETRY).is_file()


def open_recording(path: Path) -> Recording:
    """Reads the poses of a folder.

    The video may end a few frames before the odometry. Frames without an image
    are omitted.

    Raises:
        FileError: A file is missing or unreadable.
        MissingExtraError: PyAV is not installed.
    """
    odometry = path / ODOMETRY
    rows = _read_odometry(odometry)
    poses = _columns(odometry, rows, _POSE)
    try:
        X_WC = poses_from_quaternions(poses[:, 3:], poses[:, :3])
    except ValueError as error:
        raise FileError(odometry, str(error)) from error
    K = _intrinsics(path, rows)
    numbers = _columns(odometry, rows, ("frame",))[:, 0]
    if not np.isfinite(numbers).all():
        raise FileError(odometry, "frame numbers must be finite")
    times = _times(odometry, rows)
    numbers = numbers.astype(int).tolist()
    names = [f"frame {number:06d}" for number in numbers]

    def read_depths(
        chosen: Sequence[int],
    ) -> Iterator[tuple[int, DepthImage]]:
        height, width, count = _video_extent(path / VIDEO)
        for i in chosen:
            if not count or numbers[i] < count:
                depth = _read_depth(path, numbers[i])
                yield (
                    i,
                    DepthImage.of_color_camera(
                        names[i], K[i], (height, width), depth
                    ),
                )

    def read_frames(chosen: Sequence[int]) -> Iterator[tuple[int, Frame]]:
        wanted = {numbers[i]: i for i in chosen}
        for number, rgb in _video_frames(path / VIDEO, wanted):
            i = wanted[number]
            yield (
                i,
                Frame(
                    name=names[i],
                    K=K[i],
                    X_WC=X_WC[i],
                    rgb=rgb,
                    depth=_read_depth(path, number),
                    time=None if times is None else float(times[i]),
                ),
            )

    return Recording(X_WC, read_depths, read_frames, times)


def notes(path: Path) -> list[str]:
    """Returns notes on unused data of a folder; does not read frames."""
    rows = _read_odometry(path / ODOMETRY)
    numbers = _columns(path / ODOMETRY, rows, ("frame",))[:, 0].astype(int)
    used = {f"{number:06d}" for number in numbers.tolist()}
    depths = [file.stem for file in images_in(path / "depth")]
    return note_left_out(depths, used, "a pose")


def _read_odometry(path: Path) -> list[dict]:
    """The rows of the table, each a dictionary from columns to words."""
    lines = read_text(path).splitlines()
    rows = list(csv.DictReader(lines, skipinitialspace=True))
    if not rows:
        raise FileError(path, "expected a header and one row for each frame")
    if any(None in row.values() for row in rows):
        raise FileError(path, "a row is shorter than the header")
    return rows


def _columns(
    path: Path, rows: list[dict], names: tuple[str, ...]
) -> np.ndarray:
    """Columns of a table as numbers, (n, len(names))."""
    missing = [name for name in names if name not in rows[0]]
    if missing:
        raise FileError(path, f"has no column {', '.join(missing)}")
    try:
        return np.array([[row[name] for name in names] for row in rows], float)
    except (TypeError, ValueError) as error:
        raise FileError(path, f"expected numbers: {error}") from error


def _times(path: Path, rows: list[dict]) -> np.ndarray | None:
    """Times of the rows, (n,) [s]; None in the oldest versions."""
    if "timestamp" not in rows[0]:
        return None
    return _columns(path, rows, ("timestamp",))[:, 0]


def _intrinsics(path: Path, rows: list[dict]) -> np.ndarray:
    """K at the video's size, (n, 3, 3)."""
    if all(name in rows[0] for name in _CAMERA):
        K = np.tile(np.eye(3), (len(rows), 1, 1))
        values = _columns(path / ODOMETRY, rows, _CAMERA)
        K[:, [0, 1, 0, 1], [0, 1, 2, 2]] = values
        return K
    matrix = read_matrix(path / "camera_matrix.csv", (3, 3))
    return np.tile(matrix, (len(rows), 1, 1))


def _read_depth(path: Path, number: int) -> np.ndarray:
    depth_file = path / "depth" / f"{number:06d}.png"
    if not depth_file.is_file() and depth_file.with_suffix(".npy").is_file():
        depth_file = depth_file.with_suffix(".npy")
    depth = read_depth(depth_file, DEPTH_UNIT)
    confidence = path / "confidence" / f"{number:06d}.png"
    if confidence.is_file():
        depth = keep_confident(confidence, depth, read_levels(confidence))
    return depth


def _video_extent(path: Path) -> tuple[int, int, int]:
    """Height, width and number of frames of a video; 0 if unknown."""
    with _opened_video(path) as video:
        stream = video.streams.video[0]
        return stream.height, stream.width, stream.frames


def _video_frames(
    path: Path, wanted: Collection[int]
) -> Iterator[tuple[int, np.ndarray]]:
    """Yields numbers and colours (h, w, 3) of some frames of a video."""
    last = max(wanted, default=-1)
    with _opened_video(path) as video:
        video.streams.video[0].thread_type = "AUTO"
        for number, image in enumerate(video.decode(video=0)):
            if number in wanted:
                yield number, image.to_ndarray(format="rgb24")
            if number >= last:
                return


@contextmanager
def _opened_video(path: Path) -> Iterator[Any]:
    """Opens a video, and checks its codec and its size."""
    try:
        import av
    except ImportError as error:
        raise MissingExtraError(
            "the video of a capture", "reconstruction"
        ) from error
    try:
        with av.open(str(path)) as video:
            streams = video.streams.video
            # The context of a stream with an unknown codec is None.
            if not streams or streams[0].codec_context is None:
                raise FileError(path, "contains no video that can be decoded")
            camera = streams[0].codec_context
            check_pixel_count(path, camera.width, camera.height)
            yield video
    except (av.FFmpegError, UnicodeDecodeError) as error:
        raise FileError(path, f"unreadable video: {error}") from error
