"""`read_capture`: posed RGB-D images from any file or folder we know.

A format is what it looks for, whether it recognises a path, an iterator over
its frames, and notes about what those leave out. Adding one is a module and a
line here.
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
    """A format in which captures are stored.

    Attributes:
        looks_for: What the format looks for in a path, in words.
        recognises: Function that returns whether a path is of this format, by
            what it holds.
        read_frames: Function that iterates over every n-th frame of a path.
        notes: Function that tells what the frames of a path leave out.
        up_W: Unit vector against gravity in the world of all captures of this
            format; None where it documents none.
    """

    looks_for: str
    recognises: Callable[[Path], bool]
    read_frames: Callable[[Path, int], Iterator[Frame]]
    notes: Callable[[Path], list[str]]
    up_W: tuple[float, ...] | None = None


FORMATS = {
    name: Format(
        module.LOOKS_FOR,
        module.recognises,
        module.read_frames,
        module.notes,
        getattr(module, "UP_W", None),
    )
    for name, module in {
        "nerfstudio": nerfstudio,
        "record3d": record3d,
        "stray-scanner": stray_scanner,
        "tum": tum,
        "7-scenes": seven_scenes,
        "trajectory-log": trajectory_log,
    }.items()
}
"""All formats by name, in the order in which they are tried.

"nerfstudio" is also the format of instant-ngp and of NeRFCapture.
"""


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
        format: A name of `FORMATS`; None detects it by the content.
        stride: Only every n-th frame is read.
        max_depth: Largest depth that is trusted; deeper pixels become unknown
            [m].
        max_size: Largest width or height; larger images are shrunk to it
            [pixels].

    Raises:
        FileError: Something is missing, damaged, too large, of no known
            format, or does not fit the rest.
        FieldError: A field of a file, or an argument, is unusable.
        RemoSplatError: A pose is no rigid transform; the error names the frame.
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
    capture = assemble(path, frames, max_depth=max_depth, max_size=max_size)
    return dc.replace(
        capture,
        notes=tuple(FORMATS[name].notes(path)),
        up_W=FORMATS[name].up_W,
    )


def detect_format(path: Path) -> str:
    """Detects the format of a file or folder by its content.

    Returns:
        A name of `FORMATS`.

    Raises:
        FileError: The path has none of these formats.
    """
    if not path.exists():
        raise FileError(path, "no such file or folder")
    for name, candidate in FORMATS.items():
        if candidate.recognises(path):
            return name
    expected = "; ".join(f"{n}: {f.looks_for}" for n, f in FORMATS.items())
    raise FileError(path, f"no known capture; expected {expected}")
