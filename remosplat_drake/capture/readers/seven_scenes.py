"""Captures in the layout of Microsoft's 7-Scenes and of 3DMatch.

Files `frame-XXXXXX.color.png` (or .jpg), `.depth.png` and `.pose.txt` lie in
one folder; `camera-intrinsics.txt` in that one or the one above. Poses are
camera-to-world (OpenCV axes). Depth is in millimetres, 0 or 65535 where there
is none, and has to be registered to colour: the camera is that of both.
"""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from remosplat_drake.base.errors import FileError
from remosplat_drake.capture.frames import Frame
from remosplat_drake.capture.images import read_colors, read_depth
from remosplat_drake.capture.readers.image_lists import (
    in_natural_order,
    note_left_out,
)
from remosplat_drake.capture.readers.intrinsics import find_intrinsics
from remosplat_drake.capture.readers.text_files import read_matrix

DEPTH_UNIT = 1e-3
"""Length of one step of a depth image [m]."""

_NO_DEPTH = 65535 * DEPTH_UNIT
_POSE = ".pose.txt"

LOOKS_FOR = f"a folder with frame-*{_POSE}"
"""What `recognises` looks for, in words."""


def recognises(path: Path) -> bool:
    """Returns whether a path is a folder of 7-Scenes or 3DMatch."""
    return next(path.glob(f"frame-*{_POSE}"), None) is not None


def read_frames(path: Path, stride: int) -> Iterator[Frame]:
    """Reads every `stride`-th frame.

    Raises:
        FileError: A file is missing or unreadable.
    """
    K = find_intrinsics(path, path.resolve().parent)
    for pose in _poses(path)[::stride]:
        name = pose.name.removesuffix(_POSE)
        depth = read_depth(path / f"{name}.depth.png", DEPTH_UNIT)
        yield Frame(
            name=name,
            K=K,
            X_WC=read_matrix(pose, (4, 4)),
            rgb=read_colors(_color_file(path, name)),
            depth=np.where(depth >= np.float32(_NO_DEPTH), 0, depth),
        )


def notes(path: Path) -> list[str]:
    """Returns what a reader should know of a folder beside its frames."""
    names = [pose.name.removesuffix(_POSE) for pose in _poses(path)]
    colors = in_natural_order(
        [*path.glob("frame-*.color.png"), *path.glob("frame-*.color.jpg")]
    )
    used = [f"{name}.color.{end}" for name in names for end in ("png", "jpg")]
    return note_left_out([f.name for f in colors], set(used), "a pose")


def _poses(path: Path) -> list[Path]:
    return in_natural_order(list(path.glob(f"frame-*{_POSE}")))


def _color_file(path: Path, name: str) -> Path:
    for suffix in ("png", "jpg"):
        candidate = path / f"{name}.color.{suffix}"
        if candidate.is_file():
            return candidate
    raise FileError(path / f"{name}.color.png", "no such file (nor .jpg)")
