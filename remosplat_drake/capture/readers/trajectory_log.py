"""Reads captures with a trajectory.log, as Redwood and Open3D write them.

For each frame, the log has a line of three numbers, the first of which is the
frame's number, and a 4x4 camera-to-world pose (OpenCV axes). One folder
contains the colour images, and another one the depth images. Frame i is the
i-th image of each folder, in the order of the numbers in the names. Depth is in
millimetres. The capture's folder also contains a camera file (Open3D's JSON or
a 3x3 matrix).
"""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from remosplat_drake.base.errors import FileError
from remosplat_drake.capture.frames import Frame
from remosplat_drake.capture.images import read_colors, read_depth, read_size
from remosplat_drake.capture.readers.image_lists import (
    images_in,
    note_left_out,
)
from remosplat_drake.capture.readers.intrinsics import find_intrinsics
from remosplat_drake.capture.readers.text_files import as_matrix, read_rows
from remosplat_drake.capture.recording import DepthImage, Recording

DEPTH_UNIT = 1e-3
"""Length of one step of a depth image [m]."""

_LOGS = ("trajectory.log", "scene/trajectory.log", "odometry.log")
_COLOR_FOLDERS = ("color", "rgb", "image")

EXPECTED_FILES = f"a folder with {' or '.join(_LOGS)}"
"""Description of the files that `recognises` accepts."""


def recognises(path: Path) -> bool:
    """Returns whether a path is a folder with a trajectory log."""
    return any((path / log).is_file() for log in _LOGS)


def open_recording(path: Path) -> Recording:
    """Reads the trajectory of a folder.

    Raises:
        FileError: A file is missing or unreadable.
    """
    log = _log(path)
    K = find_intrinsics(path)
    colors = _images(path, _COLOR_FOLDERS)
    depths = _images(path, ("depth",))
    if len(colors) != len(depths):
        raise FileError(
            path,
            f"there are {len(colors)} colour images, but {len(depths)} depth"
            " images",
        )
    entries = read_log(log)
    X_WC = np.array([pose for _, pose in entries])

    def number(i: int) -> tuple[int, str]:
        index = entries[i][0]
        if not 0 <= index < len(colors):
            raise FileError(
                log,
                f"frame {index} has no image: there are {len(colors)} images",
            )
        return index, f"frame {index} ({colors[index].name})"

    def read_depths(
        chosen: Sequence[int],
    ) -> Iterator[tuple[int, DepthImage]]:
        for i in chosen:
            index, name = number(i)
            size = read_size(colors[index])
            depth = read_depth(depths[index], DEPTH_UNIT)
            yield i, DepthImage.of_color_camera(name, K, size, depth)

    def read_frames(chosen: Sequence[int]) -> Iterator[tuple[int, Frame]]:
        for i in chosen:
            index, name = number(i)
            yield (
                i,
                Frame(
                    name=name,
                    K=K,
                    X_WC=X_WC[i],
                    rgb=read_colors(colors[index]),
                    depth=read_depth(depths[index], DEPTH_UNIT),
                ),
            )

    return Recording(X_WC, read_depths, read_frames)


def notes(path: Path) -> list[str]:
    """Returns notes on unused data of a folder; does not read frames."""
    colors = _images(path, _COLOR_FOLDERS)
    used = {colors[i].name for i, _ in read_log(_log(path))}
    return note_left_out([f.name for f in colors], used, "a pose")


def _log(path: Path) -> Path:
    """The trajectory log of a folder."""
    for name in _LOGS:
        if (path / name).is_file():
            return path / name
    raise FileError(path, f"expected {EXPECTED_FILES}")


def read_log(path: Path) -> list[tuple[int, np.ndarray]]:
    """Reads the frame numbers and poses X_WC, shape (4, 4), of a log.

    Raises:
        FileError: The file is missing, or is not a trajectory log.
    """
    rows = read_rows(path)
    if not rows or len(rows) % 5:
        raise FileError(path, "expected five lines for each frame")
    entries = []
    for start in range(0, len(rows), 5):
        header = as_matrix(path, [rows[start]], (1, len(rows[start])))[0]
        if not float(header[0]).is_integer():
            raise FileError(
                path, f"expected a frame number, got {rows[start][0]}"
            )
        X_WC = as_matrix(path, rows[start + 1 : start + 5], (4, 4))
        entries.append((int(header[0]), X_WC))
    return entries


def _images(path: Path, folders: tuple[str, ...]) -> list[Path]:
    """The images of the first folder that exists, in natural order."""
    for name in folders:
        if (path / name).is_dir():
            return images_in(path / name)
    raise FileError(path, f"expected a folder {' or '.join(folders)}")
