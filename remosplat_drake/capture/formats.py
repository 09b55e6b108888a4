"""`read_capture`: posed RGB-D images from any file or folder we know.

A format is three things: what it looks for, whether it recognises a path,
and an iterator over its frames. Adding one is a module and a line here.
"""

import dataclasses as dc
from collections.abc import Callable, Iterator
from pathlib import Path

from remosplat_drake.base.errors import FieldError, FileError, unknown_name
from remosplat_drake.base.reading import reads_file
from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.frames import Frame, assemble
from remosplat_drake.capture.readers import (
    nerfstudio,
    record3d,
    seven_scenes,
    stray_scanner,
    trajectory_log,
    tum,
)


@dc.dataclass(frozen=True)
class Format:
    """How captures of one kind are told from others, and read.

    Attributes:
        looks_for: In words.
        recognises: Whether a path is of this kind, by what it holds.
        read_frames: Every n-th frame of a path.
    """

    looks_for: str
    recognises: Callable[[Path], bool]
    read_frames: Callable[[Path, int], Iterator[Frame]]


FORMATS = {
    name: Format(module.LOOKS_FOR, module.recognises, module.read_frames)
    for name, module in {
        "nerfstudio": nerfstudio,
        "record3d": record3d,
        "stray-scanner": stray_scanner,
        "tum": tum,
        "7-scenes": seven_scenes,
        "trajectory-log": trajectory_log,
    }.items()
}
"""By name, in the order in which they are tried. "nerfstudio" is instant-ngp's
and NeRFCapture's format too."""


@reads_file
def read_capture(
    path: str | Path,
    format: str | None = None,
    *,
    stride: int = 1,
    max_depth: float | None = None,
    max_size: int | None = None,
) -> Capture:
    """Reads a capture: undistorted images of one size, in metres.

    Colour and depth of different size both get the smaller one; colours are
    averaged over areas, depths are picked.

    Args:
        path: A file or folder.
        format: A name of `FORMATS`; None tells it by the content.
        stride: Only every n-th frame is read.
        max_depth: Depths beyond become unknown [m].
        max_size: Wider or higher images are shrunk to this [pixels].

    Raises:
        FileError: Something is missing, damaged, too large, of no known
            format, or does not fit the rest.
        FieldError: A field of a file, or an argument, is unusable.
        RemoSplatError: A pose is no rigid transform; names the frame.
        MissingExtraError: A reader's package is not installed.
    """
    path = Path(path).expanduser()
    for name, value in (
        ("stride", stride),
        ("max_depth", max_depth),
        ("max_size", max_size),
    ):
        if value is not None and not value > 0:
            raise FieldError("read_capture", name, "must be positive")
    name = detect_format(path) if format is None else format
    if name not in FORMATS:
        raise FieldError(
            str(path), "format", unknown_name("capture format", name, FORMATS)
        )
    if not path.exists():
        raise FileError(path, "no such file or folder")
    frames = FORMATS[name].read_frames(path, stride)
    return assemble(path, frames, max_depth=max_depth, max_size=max_size)


def detect_format(path: Path) -> str:
    """The name of the format that a file or folder has.

    Raises:
        FileError: It has none that we know.
    """
    if not path.exists():
        raise FileError(path, "no such file or folder")
    for name, candidate in FORMATS.items():
        if candidate.recognises(path):
            return name
    expected = "; ".join(f"{n}: {f.looks_for}" for n, f in FORMATS.items())
    raise FileError(path, f"no known capture; expected {expected}")
