"""Reads captures in the layout of Microsoft's 7-Scenes and of 3DMatch.

The files `frame-XXXXXX.color.png` (or .jpg), `.depth.png` and `.pose.txt` are
in one folder, and `camera-intrinsics.txt` is in the same folder or its parent.
Poses are camera-to-world (OpenCV axes). Depth is in millimetres, and is 0 or
65535 where unknown. Depth must be registered to colour, since the file
describes only one camera for both images.
"""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from remosplat_drake.base.errors import FileError
from remosplat_drake.capture.frames import Frame
from remosplat_drake.capture.images import read_colors, read_depth, read_size
from remosplat_drake.capture.readers.image_lists import (
    in_natural_order,
    note_left_out,
)
from remosplat_drake.capture.readers.intrinsics import find_intrinsics
from remosplat_drake.capture.readers.text_files import read_matrix
from remosplat_drake.capture.recording import DepthImage, Recording

DEPTH_UNIT = 1e-3
"""Length of one step of a depth image [m]."""

_NO_DEPTH = 65535 * DEPTH_UNIT
_POSE = ".pose.txt"

EXPECTED_FILES = f"a folder with frame-*{_POSE}"
"""Description of the files that `recognises` accepts."""


def recognises(path: Path) -> bool:
    """Returns whether a path is a folder of 7-Scenes or 3DMatch."""
    return next(path.glob(f"frame-*{_POSE}"), None) is not None


def open_recording(path: Path) -> Recording:
    """Reads the poses of a folder.

    Raises:
        FileError: A file is missing or unreadable.
    """
    K = find_intrinsics(path, path.resolve().parent)
    poses = _poses(path)
    names = [pose.name.removesuffix(_POSE) for pose in poses]
    X_WC = np.array([read_matrix(pose, (4, 4)) for pose in poses])

    def read_depths(
        chosen: Sequence[int],
    ) -> Iterator[tuple[int, DepthImage]]:
        for i in chosen:
            size = read_size(_color_file(path, names[i]))
            depth = _read_depth(path, names[i])
            yield i, DepthImage.of_color_camera(names[i], K, size, depth)

    def read_frames(chosen: Sequence[int]) -> Iterator[tuple[int, Frame]]:
        for i in chosen:
            yield (
                i,
                Frame(
                    name=names[i],
                    K=K,
                    X_WC=X_WC[i],
                    rgb=read_colors(_color_file(path, names[i])),
                    depth=_read_depth(path, names[i]),
                ),
            )

    return Recording(X_WC.reshape(-1, 4, 4), read_depths, read_frames)


def notes(path: Path) -> list[str]:
    """Returns notes on unused data of a folder; does not read frames."""
    names = [pose.name.removesuffix(_POSE) for pose in _poses(path)]
    colors = in_natural_order(
        [*path.glob("frame-*.color.png"), *path.glob("frame-*.color.jpg")]
    )
    used = [f"{name}.color.{end}" for name in names for end in ("png", "jpg")]
    return note_left_out([f.name for f in colors], set(used), "a pose")


def _poses(path: Path) -> list[Path]:
    return in_natural_order(list(path.glob(f"frame-*{_POSE}")))


def _read_depth(path: Path, name: str) -> np.ndarray:
    depth = read_depth(path / f"{name}.depth.png", DEPTH_UNIT)
    return np.where(depth >= np.float32(_NO_DEPTH), 0, depth)


def _color_file(path: Path, name: str) -> Path:
    for suffix in ("png", "jpg"):
        candidate = path / f"{name}.color.{suffix}"
        if candidate.is_file():
            return candidate
    raise FileError(path / f"{name}.color.png", "no such file, nor .jpg file")
