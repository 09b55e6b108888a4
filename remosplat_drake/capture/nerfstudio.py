"""Captures as nerfstudio folders.

The folder holds `transforms.json`, colour images and depth images (PNG, 16
bit, millimetres, 0 where there is none). That format's cameras look along
their -z axis (OpenGL); ours look along +z (OpenCV). Both put the centre of
the first pixel at (0.5, 0.5).
"""

import json
from pathlib import Path

import numpy as np

from remosplat_drake.atomic_file import write_atomically
from remosplat_drake.capture.capture import Capture
from remosplat_drake.errors import FieldError, FileError, MissingExtraError

DEPTH_UNIT = 1e-3
"""One step of a stored depth image [m]."""

TRANSFORMS = "transforms.json"
_INTRINSICS = ("fl_x", "fl_y", "cx", "cy")
_FLIP_YZ = np.diag([1.0, -1.0, -1.0, 1.0])


def write_capture(folder: str | Path, capture: Capture):
    """Writes a nerfstudio folder; `transforms.json` comes last.

    Raises:
        MissingExtraError: Pillow is not installed.
    """
    image = _image_module()
    folder = Path(folder)
    for name in ("images", "depth"):
        (folder / name).mkdir(parents=True, exist_ok=True)
    frames = []
    for i, X_WC in enumerate(capture.X_WC):
        millimetres = np.rint(capture.depth[i] / DEPTH_UNIT)
        frame = {
            "file_path": f"images/{i:04d}.png",
            "depth_file_path": f"depth/{i:04d}.png",
            "transform_matrix": (X_WC @ _FLIP_YZ).tolist(),
        }
        image.fromarray(capture.rgb[i]).save(folder / frame["file_path"])
        image.fromarray(millimetres.clip(0, 65535).astype(np.uint16)).save(
            folder / frame["depth_file_path"]
        )
        frames.append(frame)
    height, width = capture.depth.shape[1:]
    K = capture.K[0]
    document = {
        "camera_model": "OPENCV",
        "w": width,
        "h": height,
        **dict(zip(_INTRINSICS, K[[0, 1, 0, 1], [0, 1, 2, 2]], strict=True)),
        "depth_unit_scale_factor": DEPTH_UNIT,
        "frames": frames,
    }
    write_atomically(folder / TRANSFORMS, json.dumps(document, indent=1) + "\n")


def read_capture(folder: str | Path) -> Capture:
    """Reads a nerfstudio folder of undistorted RGB-D images of one camera.

    Raises:
        MissingExtraError: Pillow is not installed.
        FileError: A file is missing or unreadable.
        FieldError: A field is missing or unusable.
    """
    path = Path(folder) / TRANSFORMS
    try:
        document = json.loads(path.read_text())
    except (OSError, ValueError) as error:
        raise FileError(path, " ".join(str(error).split())) from error
    frames = document.get("frames") if isinstance(document, dict) else None
    if not isinstance(frames, list) or not frames:
        raise FieldError(str(path), "frames", "expected a list of frames")
    fl_x, fl_y, cx, cy = (_number(path, document, k) for k in _INTRINSICS)
    document.setdefault("depth_unit_scale_factor", DEPTH_UNIT)
    unit = _number(path, document, "depth_unit_scale_factor")
    poses, colors, depths = [], [], []
    for i, frame in enumerate(frames):
        _check_frame(path, frame, f"frames[{i}]")
        poses.append(np.array(frame["transform_matrix"], float) @ _FLIP_YZ)
        colors.append(_read_image(path.parent / frame["file_path"])[..., :3])
        depth = _read_image(path.parent / frame["depth_file_path"])
        depths.append(depth.astype(np.float32) * np.float32(unit))
    shapes = {a.shape[:2] for a in (*colors, *depths)}
    if len(shapes) != 1:
        raise FileError(path, f"images differ in size: {sorted(shapes)}")
    return Capture(
        K=np.tile(
            [[fl_x, 0, cx], [0, fl_y, cy], [0, 0, 1]], (len(poses), 1, 1)
        ),
        X_WC=np.array(poses),
        rgb=np.array(colors, np.uint8),
        depth=np.array(depths),
    )


def _number(path: Path, document: dict, key: str) -> float:
    value = document.get(key)
    if (
        isinstance(value, bool)
        or not isinstance(value, (int, float))
        or not np.isfinite(value)
    ):
        raise FieldError(str(path), key, f"expected a number, got {value!r}")
    return float(value)


def _check_frame(path: Path, frame: object, field: str):
    """Raises a FieldError unless a frame has a pose and two files."""
    if not isinstance(frame, dict):
        raise FieldError(str(path), field, "expected an object")
    for key in ("file_path", "depth_file_path"):
        if not isinstance(frame.get(key), str):
            raise FieldError(str(path), f"{field}.{key}", "expected a file")
    try:
        X = np.array(frame.get("transform_matrix"), float)
    except (TypeError, ValueError):
        X = np.array(np.nan)
    if X.shape != (4, 4) or not np.isfinite(X).all():
        raise FieldError(
            str(path), f"{field}.transform_matrix", "expected a 4x4 pose"
        )


def _read_image(path: Path) -> np.ndarray:
    try:
        with _image_module().open(path) as image:
            return np.asarray(image)
    except OSError as error:
        raise FileError(path, f"unreadable image: {error}") from error


def _image_module():
    try:
        from PIL import Image
    except ImportError as error:
        raise MissingExtraError("RGB-D images", "reconstruction") from error
    return Image
