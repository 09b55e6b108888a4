"""Reads and writes captures of nerfstudio, instant-ngp and NeRFCapture.

A folder contains `transforms.json` and images. The cameras in the file look
along their -z axis (OpenGL), those of a `Capture` along +z (OpenCV). In both,
the centre of the first pixel is (0.5, 0.5). Camera fields of a frame override
those of the document. Paths in the document may point outside the folder, since
files are only read.

Depth images are 16-bit or float. In nerfstudio's documents, `depth_file_path`
is their path, and `depth_unit_scale_factor` their unit (by default a
millimetre). Documents of instant-ngp call them `depth_path` and
`integer_depth_scale`.

The world frame is that of the file. Positions are divided by `applied_scale`,
so that they are in metres. `applied_transform` is not undone, since it only
rotates the world frame.
"""

import dataclasses as dc
import json
import os
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from remosplat_drake.base.atomic_file import write_atomically
from remosplat_drake.base.errors import FieldError, FileError, unknown_name
from remosplat_drake.base.strict_json import as_number, shown
from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.frames import (
    Frame,
    sample_nearest,
    scale_intrinsics,
)
from remosplat_drake.capture.images import (
    check_announced_size,
    image_module,
    read_colors,
    read_depth,
    read_levels,
    read_size,
)
from remosplat_drake.capture.readers.image_lists import (
    images_in,
    note_left_out,
)
from remosplat_drake.capture.readers.poses import OPENGL_FROM_OPENCV
from remosplat_drake.capture.readers.text_files import read_json
from remosplat_drake.capture.recording import DepthImage, Recording
from remosplat_drake.capture.undistortion import Distortion

DEPTH_UNIT = 1e-3
"""Length of one step of the depth images that `write_capture` writes [m].

It is a millimetre, the default of nerfstudio, which reads the unit from its
command line and not from the file.
"""

_PNG_LEVEL = 3
"""Level of PNG compression: compared with the usual 6, writing is twice as
fast, and files are a sixth larger.
"""

TRANSFORMS = "transforms.json"
"""Name of the file that describes a capture."""
EXPECTED_FILES = f"a folder with {TRANSFORMS}, or that file"
"""Description of the files that `recognises` accepts."""

_INTRINSICS = ("fl_x", "fl_y", "cx", "cy")
_CAMERA_MODELS = (
    "OPENCV",
    "PINHOLE",
    "RADIAL",
    "SIMPLE_PINHOLE",
    "SIMPLE_RADIAL",
)
_DEPTH_UNITS = (1e-9, 1e3)
_FOCAL_LENGTHS, _FARTHEST = (1e-3, 1e7), 1e7
"""Valid camera fields of a document: range of the focal lengths, and largest
coordinate of the principal point [pixels]."""
_SUFFIXES = ("", ".png", ".jpg", ".jpeg")
_MAX_STEPS = 65535


def recognises(path: Path) -> bool:
    """Returns whether a path is a `transforms.json` or a folder with one."""
    return path.name == TRANSFORMS or (path / TRANSFORMS).is_file()


def open_recording(path: Path) -> Recording:
    """Reads the document of a folder.

    Raises:
        FileError: The document is missing or unreadable.
        FieldError: The document has no list of frames.
    """
    if path.name != TRANSFORMS:
        path = path / TRANSFORMS
    document = read_json(path)
    frames = document.get("frames")
    if not isinstance(frames, list) or not frames:
        raise FieldError(str(path), "frames", "expected a list of frames")

    def read_depths(
        chosen: Sequence[int],
    ) -> Iterator[tuple[int, DepthImage]]:
        for i in chosen:
            yield i, _read_depth_image(_fields(path, document, i))

    def read_frames(chosen: Sequence[int]) -> Iterator[tuple[int, Frame]]:
        for i in chosen:
            yield i, read_frame(path, document, i)

    entries = [_entry(path, document, i) for i in range(len(frames))]
    X_WC = np.array([pose for pose, _ in entries])
    times = np.array([time for _, time in entries])
    return Recording(
        X_WC, read_depths, read_frames, None if np.isnan(times).all() else times
    )


def _entry(path: Path, document: dict, i: int) -> tuple[np.ndarray, float]:
    """Pose and time of a frame; NaN for missing or unusable values.

    An invalid frame is reported only when it is read.
    """
    try:
        fields = _fields(path, document, i)
        X_WC, time = _pose(fields), _time(fields)
    except FieldError:
        return np.full((4, 4), np.nan), np.nan
    return X_WC, np.nan if time is None else time


def notes(path: Path) -> list[str]:
    """Returns notes on unused data of a folder; does not read frames."""
    if path.name != TRANSFORMS:
        path = path / TRANSFORMS
    # Frames that were not read may be invalid.
    names = [
        frame.get("file_path") if isinstance(frame, dict) else None
        for frame in read_json(path)["frames"]
    ]
    files = [path.parent / name for name in names if isinstance(name, str)]
    folders = dict.fromkeys(file.parent for file in files)
    if path.parent in folders:
        # The folder may contain any other files, too.
        return []
    stems = {str(file.with_suffix("")) for file in files}
    images = [image for folder in folders for image in images_in(folder)]
    colors = [i for i in images if not i.stem.endswith("depth")]
    used = {str(i) for i in colors if str(i.with_suffix("")) in stems}
    return note_left_out(
        [str(i) for i in colors], used, f"a frame in {TRANSFORMS}"
    )


def read_frame(path: Path, document: dict, i: int) -> Frame:
    """Reads frame i of a document.

    Args:
        path: Path of the document, `transforms.json`.
        document: Content of the document.
        i: Index of the frame.

    Raises:
        FileError: A file is missing or unreadable.
        FieldError: A field is missing or unusable.
    """
    return _read_frame(_fields(path, document, i))


@dc.dataclass(frozen=True)
class _Fields:
    """The fields of one frame; the document's fields are the defaults."""

    path: Path
    document: dict
    frame: dict
    name: str

    def has(self, key: str) -> bool:
        return key in self.frame or key in self.document

    def number(self, key: str, default: float | None = None) -> float:
        fields = self.frame if key in self.frame else self.document
        return as_number(self.path, self.field(key), fields.get(key, default))

    def field(self, key: str) -> str:
        """Path of a field, such as "frames[3].cx"."""
        return f"{self.name}.{key}" if key in self.frame else key

    def within(
        self, key: str, default: float | None, least: float, most: float
    ) -> float:
        """Reads a number that must lie within bounds."""
        value = self.number(key, default)
        if not least <= value <= most:
            raise FieldError(
                str(self.path),
                self.field(key),
                f"must be from {least:.10g} to {most:.10g}, got {value:g}",
            )
        return value

    def file(self, key: str) -> Path:
        """Returns the file that a field names, with or without suffix."""
        name = self.frame.get(key)
        if not isinstance(name, str) or not name:
            raise self.error(key, f"expected a file, got {shown(name)}")
        stem = self.path.parent / name
        for suffix in _SUFFIXES:
            candidate = Path(f"{stem}{suffix}")
            if os.path.isfile(candidate):
                return candidate
        raise FileError(stem, f"no such file ({self.name}.{key})")

    def error(self, key: str, problem: str) -> FieldError:
        return FieldError(str(self.path), f"{self.name}.{key}", problem)


def _fields(path: Path, document: dict, i: int) -> _Fields:
    frame = document["frames"][i]
    if not isinstance(frame, dict):
        raise FieldError(str(path), f"frames[{i}]", "expected an object")
    return _Fields(path, document, frame, f"frames[{i}]")


def _read_frame(fields: _Fields) -> Frame:
    _check_camera_model(fields)
    rgb = read_colors(fields.file("file_path"))
    lens = {
        field.name: fields.within(field.name, 0.0, -1e6, 1e6)
        for field in dc.fields(Distortion)
    }
    return Frame(
        name=_name(fields),
        K=_intrinsics(fields, rgb.shape[:2]),
        X_WC=_pose(fields),
        rgb=rgb,
        depth=_read_depth(fields),
        hidden=_read_hidden(fields),
        distortion=Distortion(**lens),
        time=_time(fields),
    )


def _read_depth_image(fields: _Fields) -> DepthImage:
    """Reads the depth of a frame, without undistortion."""
    _check_camera_model(fields)
    color_size = read_size(fields.file("file_path"))
    depth, hidden = _read_depth(fields), _read_hidden(fields)
    if hidden is not None:
        size = depth.shape[0], depth.shape[1]
        depth = np.where(sample_nearest(hidden, size), np.float32(0), depth)
    K = _intrinsics(fields, color_size)
    return DepthImage.of_color_camera(_name(fields), K, color_size, depth)


def _name(fields: _Fields) -> str:
    return f"{fields.name} ({fields.frame['file_path']})"


def _time(fields: _Fields) -> float | None:
    """Time of a frame [s], as NeRFCapture's documents define it."""
    if "timestamp" not in fields.frame:
        return None
    return fields.number("timestamp")


def _read_hidden(fields: _Fields) -> np.ndarray | None:
    if fields.frame.get("mask_path") is None:
        return None
    return read_levels(fields.file("mask_path")) < 128


def _read_depth(fields: _Fields) -> np.ndarray:
    if "depth_path" in fields.frame and "depth_file_path" not in fields.frame:
        unit = fields.within("integer_depth_scale", None, *_DEPTH_UNITS)
        return read_depth(fields.file("depth_path"), unit)
    unit = fields.within("depth_unit_scale_factor", DEPTH_UNIT, *_DEPTH_UNITS)
    return read_depth(fields.file("depth_file_path"), unit)


def _check_camera_model(fields: _Fields):
    model = fields.frame.get(
        "camera_model", fields.document.get("camera_model", "OPENCV")
    )
    if fields.document.get("is_fisheye"):
        model = "OPENCV_FISHEYE"
    if model not in _CAMERA_MODELS:
        raise FieldError(
            str(fields.path),
            "camera_model",
            unknown_name("camera model", model, _CAMERA_MODELS),
        )


def _intrinsics(fields: _Fields, size: tuple[int, int]) -> np.ndarray:
    """The matrix K for images of this size (height, width)."""
    width = fields.number("w", size[1])
    height = fields.number("h", size[0])
    check_announced_size(str(fields.path), "w, h", width, height)
    if fields.has("fl_x") or not fields.has("camera_angle_x"):
        fl_x = fields.within("fl_x", None, *_FOCAL_LENGTHS)
        fl_y = fields.within("fl_y", fl_x, *_FOCAL_LENGTHS)
    else:
        fl_x = width / 2 / np.tan(_angle(fields, "camera_angle_x") / 2)
        fl_y = fl_x
        if fields.has("camera_angle_y"):
            fl_y = height / 2 / np.tan(_angle(fields, "camera_angle_y") / 2)
    cx = fields.within("cx", width / 2, -_FARTHEST, _FARTHEST)
    cy = fields.within("cy", height / 2, -_FARTHEST, _FARTHEST)
    K = np.array([[fl_x, 0, cx], [0, fl_y, cy], [0, 0, 1]])
    if abs(width * size[0] - height * size[1]) > 0.02 * height * size[1]:
        raise FileError(
            fields.path,
            f"{fields.name}: w and h are {width:g}x{height:g}, but the image"
            f" is {size[1]}x{size[0]}",
        )
    return scale_intrinsics(K, (height, width), size)


def _angle(fields: _Fields, key: str) -> float:
    """An angle of view [rad]."""
    angle = fields.number(key)
    if not 0 < angle < np.pi:
        raise FieldError(str(fields.path), key, "must be between 0 and pi")
    return angle


def _pose(fields: _Fields) -> np.ndarray:
    """X_WC in OpenCV axes, in metres."""
    matrix = _finite_matrix(fields.frame.get("transform_matrix"), (4, 4))
    if matrix is None:
        raise fields.error(
            "transform_matrix", "expected a 4x4 pose of finite numbers"
        )
    X_WC = matrix @ OPENGL_FROM_OPENCV
    scale = fields.within("applied_scale", 1.0, 1e-6, 1e6)
    X_WC[:3, 3] /= scale
    applied = fields.document.get("applied_transform")
    if applied is not None:
        A = _finite_matrix(applied, (3, 4), (4, 4))
        if A is None or abs(A[:3, :3] @ A[:3, :3].T - np.eye(3)).max() > 1e-3:
            raise FieldError(
                str(fields.path),
                "applied_transform",
                "expected a 3x4 rigid motion; only metric captures can be used",
            )
    return X_WC


def _finite_matrix(
    value: object, *shapes: tuple[int, int]
) -> np.ndarray | None:
    """A matrix of one of the shapes; None if the value is no such matrix."""
    try:
        matrix = np.array(value, float)
    except (TypeError, ValueError):
        return None
    usable = matrix.shape in shapes and np.isfinite(matrix).all()
    return matrix if usable else None


def write_capture(folder: str | Path, capture: Capture):
    """Writes a capture as a nerfstudio folder.

    An existing `transforms.json` is removed first, since it would not match
    partly replaced images. The new one is written last. Depth is rounded to
    millimetres, and is unknown beyond 65.535 m. All other data are preserved.

    Args:
        folder: The folder to write.
        capture: The capture.

    Raises:
        FileError: The folder cannot be written.
        MissingExtraError: Pillow is not installed.
    """
    folder = Path(folder)
    try:
        (folder / TRANSFORMS).unlink(missing_ok=True)
    except OSError as error:
        problem = f"cannot be replaced: {error.strerror or error}"
        raise FileError(folder / TRANSFORMS, problem) from error
    height, width = capture.size
    same_camera = bool((capture.K[0] == capture.K).all())
    frames = []
    for view in range(len(capture)):
        camera = {} if same_camera else camera_fields(capture.K[view])
        name = f"{view:04d}"
        frames.append(write_images(folder, name, capture, view) | camera)
    document = {
        "camera_model": "OPENCV",
        "w": width,
        "h": height,
        **(camera_fields(capture.K[0]) if same_camera else {}),
        "depth_unit_scale_factor": DEPTH_UNIT,
        "frames": frames,
    }
    write_atomically(folder / TRANSFORMS, json.dumps(document, indent=1) + "\n")


def write_images(
    folder: Path, name: str, capture: Capture, view: int = 0
) -> dict:
    """Writes the images of a view.

    Args:
        folder: Folder of the document.
        name: Name of the image files, without suffix.
        capture: The capture that holds the view.
        view: Index of the view.

    Returns:
        The view's entry in `transforms.json`, without the camera's fields.

    Raises:
        FileError: A file cannot be written.
        MissingExtraError: Pillow is not installed.
    """
    steps = np.rint(capture.depth[view] / DEPTH_UNIT)
    steps = np.where(steps > _MAX_STEPS, 0, steps).astype(np.uint16)
    images = {
        "file_path": ("images", capture.rgb[view]),
        "depth_file_path": ("depth", steps),
    }
    if capture.hidden is not None:
        shown = np.where(capture.hidden[view], 0, 255).astype(np.uint8)
        images["mask_path"] = ("masks", shown)
    entry = {}
    for key, (kind, pixels) in images.items():
        entry[key] = f"{kind}/{name}.png"
        path = folder / entry[key]
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            image_module().fromarray(pixels).save(
                path, compress_level=_PNG_LEVEL
            )
        except OSError as error:
            raise FileError(path, f"cannot be written: {error}") from error
    X_WC_gl = capture.X_WC[view] @ OPENGL_FROM_OPENCV
    return entry | {"transform_matrix": X_WC_gl.tolist()}


def camera_fields(K: np.ndarray) -> dict[str, float]:
    """Returns the fields fl_x, fl_y, cx and cy of an intrinsic matrix K."""
    values = K[[0, 1, 0, 1], [0, 1, 2, 2]].tolist()
    return dict(zip(_INTRINSICS, values, strict=True))
