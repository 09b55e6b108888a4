"""`read_capture`: posed RGB-D images from files of all supported formats.

A `Format` consists of a description and of functions. They recognise the files,
read poses and images, and report unusable frames. To add a format, write a
module with these functions, and add an entry to `FORMATS`.
"""

import dataclasses as dc
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np

from remosplat_drake.base.errors import FieldError, FileError, unknown_name
from remosplat_drake.base.kept_stages import NOTHING_KEPT, KeptStages
from remosplat_drake.base.reading import reads_file
from remosplat_drake.capture.capture import Capture, check_camera
from remosplat_drake.capture.frames import Frame, assemble
from remosplat_drake.capture.keyframes import (
    Keyframes,
    choose_keyframes,
    looks_of_view,
    sharpness,
)
from remosplat_drake.capture.motion import (
    camera_accelerations,
    camera_velocities,
)
from remosplat_drake.capture.readers import (
    nerfstudio,
    record3d,
    seven_scenes,
    stray_scanner,
    trajectory_log,
    tum,
)
from remosplat_drake.capture.recording import Recording

Report = Callable[[str, int, int], None]
"""Type of a callback for progress: it receives the name of the stage, the
number of frames that were read, and the total number."""


@dc.dataclass(frozen=True)
class Format:
    """A format in which captures are stored.

    Attributes:
        expected_files: Description of the files of the format.
        recognises: Function that returns whether a file or folder has this
            format, judged by its content.
        open_recording: Function that reads the poses of a capture's files, but
            not yet its images.
        notes: Function that reports which frames of the files cannot be used,
            and why.
        up_W: Unit vector opposite to gravity in the world frame of all captures
            of this format; None if the format does not define it.
    """

    expected_files: str
    recognises: Callable[[Path], bool]
    open_recording: Callable[[Path], Recording]
    notes: Callable[[Path], list[str]]
    up_W: tuple[float, ...] | None = None


FORMATS = {
    name: Format(
        module.EXPECTED_FILES,
        module.recognises,
        module.open_recording,
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


@dc.dataclass(frozen=True)
class ReadingConfig:
    """Settings for reading a capture.

    Attributes:
        stride: Step between the frames that are considered; 1 means all frames.
        keyframes: Largest number of frames that are read in full. If there are
            more, `choose_keyframes` selects some of them. 0 means all frames.
        max_depth: Largest depth that is used [m]; the depth of more distant
            pixels becomes unknown.
        max_size: Largest width and height of images [pixels]; larger images are
            shrunk to this size.

    Raises:
        FieldError: A number is out of its range.
    """

    stride: int = 1
    keyframes: int = 0
    max_depth: float | None = None
    max_size: int | None = None

    def __post_init__(self):
        for name in ("stride", "max_depth", "max_size"):
            value = getattr(self, name)
            if value is not None and not value > 0:
                raise FieldError("read_capture", name, "must be positive")
        if self.keyframes < 0:
            raise FieldError(
                "read_capture", "keyframes", "must not be negative"
            )


def read_capture(
    path: str | Path,
    format: str | None = None,
    *,
    stride: int = 1,
    max_depth: float | None = None,
    max_size: int | None = None,
) -> Capture:
    """Reads a capture, and converts it to undistorted images of one size.

    Lengths are in metres. If colour and depth images differ in size, the larger
    image is shrunk: colours are averaged over areas, and depths are taken from
    the nearest pixel.

    Args:
        path: A file or folder.
        format: A name of `FORMATS`; None detects it by the content.
        stride: Step between the frames that are read; 1 means all frames.
        max_depth: Largest depth that is used [m]; the depth of more distant
            pixels becomes unknown.
        max_size: Largest width and height of images [pixels]; larger images are
            shrunk to this size.

    Raises:
        FileError: A file is missing, damaged, too large or inconsistent with
            others, or the format is unknown.
        FieldError: A field of a file, or an argument, is invalid.
        RemoSplatError: A pose is not a rigid transform; the error names the
            frame.
        MissingExtraError: A package that the format's reader needs is not
            installed.
    """
    config = ReadingConfig(stride, 0, max_depth, max_size)
    return read_keyframes(path, format, config)[0]


@reads_file
def read_keyframes(
    path: str | Path,
    format: str | None,
    config: ReadingConfig,
    report: Report = lambda what, done, total: None,
    stages: KeptStages = NOTHING_KEPT,
) -> tuple[Capture, Keyframes | None]:
    """Reads the frames of a capture that together show all of its surfaces.

    The poses of all frames are read first. Then the depth images are read,
    which are small, and frames are selected. Only the selected frames are read
    in full.

    Args:
        path: A file or folder.
        format: A name of `FORMATS`; None detects it by the content.
        config: Number of frames, and limits of depth and image size.
        report: Called with the progress, see `Report`.
        stages: Storage of intermediate results, in which the selection is kept
            for later runs.

    Returns:
        The capture, as `read_capture` returns it, and the selection of frames,
        which is None if all frames were read.

    Raises:
        RemoSplatError: As in `read_capture`.
    """
    path = Path(path).expanduser()
    form = _format_of(path, format)
    recording = form.open_recording(path)
    velocity_W = _velocities(recording)
    wanted: Sequence[int] = range(0, len(recording), config.stride)
    keyframes = None
    if 0 < config.keyframes < len(wanted):
        keyframes = stages.kept(
            "keyframes",
            Keyframes,
            [_stamps(path), recording.X_WC, velocity_W, config],
            lambda: _choose(
                path, recording, wanted, velocity_W, config, report
            ),
        )
        wanted = [wanted[i] for i in keyframes.chosen.tolist()]
    taken: list[int] = []

    def frames() -> Iterator[Frame]:
        for i, frame in recording.read_frames(wanted):
            report("reading frames", len(taken), len(wanted))
            taken.append(i)
            yield frame

    capture = assemble(
        path, frames(), max_depth=config.max_depth, max_size=config.max_size
    )
    acceleration_W = _accelerations(recording, velocity_W)
    capture = dc.replace(
        capture,
        notes=tuple(form.notes(path)),
        up_W=form.up_W,
        velocity_W=_if_known(velocity_W[taken]),
        acceleration_W=_if_known(acceleration_W[taken]),
    )
    return capture, keyframes


def _format_of(path: Path, name: str | None) -> Format:
    """Returns the named format, or detects the format by the content.

    Raises:
        RemoSplatError: The file does not exist, or has no known format.
    """
    name = detect_format(path) if name is None else name
    if name not in FORMATS:
        raise FieldError(
            str(path), "format", unknown_name("capture format", name, FORMATS)
        )
    if not path.exists():
        raise FileError(path, "no such file or folder")
    return FORMATS[name]


def _if_known(motion: np.ndarray) -> np.ndarray | None:
    """Returns the values of all frames, or None if one is unknown."""
    return motion if np.isfinite(motion).all() else None


def _stamps(path: Path) -> list[tuple[str, int, int]]:
    """Returns name, size and time of a capture's files, to detect changes."""
    files = sorted(path.rglob("*")) if path.is_dir() else [path]
    stats = [(str(file), file.stat()) for file in files if file.is_file()]
    return [(name, stat.st_size, stat.st_mtime_ns) for name, stat in stats]


def _velocities(recording: Recording) -> np.ndarray:
    """The cameras' velocities, (n, 6); NaN where they are unknown."""
    if recording.times is None:
        return np.full((len(recording), 6), np.nan)
    return camera_velocities(recording.times, recording.X_WC)


def _accelerations(recording: Recording, velocity_W: np.ndarray) -> np.ndarray:
    """Accelerations of the cameras, (n, 6); NaN if unknown."""
    if recording.times is None:
        return np.full((len(recording), 6), np.nan)
    return camera_accelerations(recording.times, velocity_W)


def _choose(
    path: Path,
    recording: Recording,
    wanted: Sequence[int],
    velocity_W: np.ndarray,
    config: ReadingConfig,
    report: Report,
) -> Keyframes:
    """Reads all depth images at a small size, and selects frames."""
    looks, sharp = [], []
    for i, image in recording.read_depths(wanted):
        report("choosing keyframes", len(looks), len(wanted))
        K, X_WC, depth = image.K, recording.X_WC[i], image.depth
        check_camera(f"{path}: {image.name}", K, X_WC)
        if config.max_depth is not None:
            depth = np.where(depth > config.max_depth, 0, depth)
        known = depth[depth > 0]
        usual = float(np.median(known)) if len(known) else 1.0
        looks.append(looks_of_view(K, depth, X_WC))
        sharp.append(sharpness(velocity_W[i], float(K[0, 0]), usual))
    return choose_keyframes(looks, np.array(sharp), config.keyframes)


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
    expected = "; ".join(f"{n}: {f.expected_files}" for n, f in FORMATS.items())
    raise FileError(path, f"no capture of a known format; expected {expected}")
