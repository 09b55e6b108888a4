"""`Views`: the training cameras of a splat, with poses and fields of view.

The cameras are read from a `transforms.json` (nerfstudio, instant-ngp). The
images that this file names are not read, and need not exist.
"""

import dataclasses as dc
from pathlib import Path
from typing import Any

import numpy as np

from remosplat_drake.base.errors import FieldError
from remosplat_drake.base.strict_json import as_number, read_json_object

TRANSFORMS = "transforms.json"
"""Name of the file with the cameras, in the folder of a splat."""

_BEFORE = 0.1
"""A point is directly in front of a camera if its depth is below this fraction
of the scene's median depth."""

_MOST, _SKEW = 1e7, 1e-3
"""Two limits: the largest valid intrinsic parameter of a camera [pixels], and
the largest deviation of its pose from a rigid transform."""


@dc.dataclass(frozen=True, eq=False)
class Views:
    """The cameras from which a splat was trained.

    Attributes:
        X_GC: Poses of the cameras C (OpenCV axes) in the splat's frame and
            unit, shape (v, 4, 4).
        K: Intrinsic matrices, shape (v, 3, 3) [pixels].
        size: Width and height of the images, shape (v, 2) [pixels].
    """

    X_GC: np.ndarray
    K: np.ndarray
    size: np.ndarray

    def __len__(self) -> int:
        return len(self.X_GC)

    def look(
        self, p_GK: np.ndarray, scene_G: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Finds points in a camera's view, and points directly in front of one.

        A point is in view if its projection is inside an image, even if it is
        occluded.

        Args:
            p_GK: The points, shape (n, 3).
            scene_G: Points of the scene, shape (m, 3). Their median depth
                determines which points are directly in front of a camera.

        Returns:
            Two masks of shape (n,), bool: the points in the view of any camera,
            and the points directly in front of any camera.
        """
        is_seen = np.zeros(len(p_GK), bool)
        is_before = np.zeros(len(p_GK), bool)
        for view in range(len(self)):
            depth, inside = self._depths(view, scene_G)
            near = _BEFORE * np.median(depth[inside]) if inside.any() else 0.0
            depth, inside = self._depths(view, p_GK)
            is_seen |= inside
            is_before |= inside & (depth < near)
        return is_seen, is_before

    def seen_share(self, p_GK: np.ndarray) -> float:
        """Returns the fraction of points in the view of any camera."""
        return float(self.look(p_GK, p_GK)[0].mean())

    def _depths(
        self, view: int, p_GK: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Returns depths of points in a camera, and which are in its image."""
        X_GC, K = self.X_GC[view], self.K[view]
        p_CK = (p_GK - X_GC[:3, 3]) @ X_GC[:3, :3]
        depth = p_CK[:, 2]
        with np.errstate(divide="ignore", invalid="ignore"):
            pixel = (p_CK @ K.T)[:, :2] / depth[:, None]
        in_image = ((pixel >= 0) & (pixel <= self.size[view])).all(axis=1)
        return depth, in_image & (depth > 0)


def read_views(path: Path) -> Views:
    """Reads the cameras of a `transforms.json`.

    Poses are used unchanged, since they have the unit and the frame of the
    splat that was trained with them. Lens distortion is ignored.

    Args:
        path: The file.

    Raises:
        FileError: The file is missing or not JSON.
        FieldError: A field is missing or invalid; the error names it.
    """
    document = read_json_object(path)
    frames = document.get("frames")
    if not isinstance(frames, list) or not frames:
        raise FieldError(str(path), "frames", "expected a list of frames")
    views = [_view(path, document, i) for i in range(len(frames))]
    X_GC, K, size = map(np.array, zip(*views, strict=True))
    return Views(X_GC, K, size)


def _view(
    path: Path, document: dict[str, Any], i: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Returns X_GC, K and the image size of a frame in the document."""
    frame, name = document["frames"][i], f"frames[{i}]"
    if not isinstance(frame, dict):
        raise FieldError(str(path), name, "expected an object")

    def number(key: str, default: float | None = None) -> float:
        """Returns a positive number of the frame, or else of the document."""
        value = frame.get(key, document.get(key, default))
        field = f"{name}.{key}" if key in frame else key
        value = as_number(path, field, value)
        if not 0 < value < _MOST:
            problem = f"must lie between 0 and {_MOST:g}, got {value:g}"
            raise FieldError(str(path), field, problem)
        return value

    width, height = number("w"), number("h")
    if "fl_x" in frame or "fl_x" in document:
        fl_x = number("fl_x")
    else:
        fl_x = 0.5 * width / np.tan(0.5 * number("camera_angle_x"))
    K = np.eye(3)
    K[0, 0], K[1, 1] = fl_x, number("fl_y", fl_x)
    K[0, 2], K[1, 2] = number("cx", 0.5 * width), number("cy", 0.5 * height)
    return _pose(path, name, frame), K, np.array([width, height])


def _pose(path: Path, name: str, frame: dict[str, Any]) -> np.ndarray:
    """Returns X_GC in OpenCV axes; the file has OpenGL axes (view along -z)."""
    field = f"{name}.transform_matrix"
    try:
        X_GC = np.array(frame.get("transform_matrix"), float)
    except (TypeError, ValueError):
        X_GC = np.zeros(0)
    if X_GC.shape != (4, 4) or not np.isfinite(X_GC).all():
        problem = "expected a 4x4 pose of finite numbers"
        raise FieldError(str(path), field, problem)
    R_GC = X_GC[:3, :3]
    if np.abs(R_GC @ R_GC.T - np.eye(3)).max() > _SKEW:
        raise FieldError(str(path), field, "is not a rotation and translation")
    X_GC[:3, 1:3] *= -1
    return X_GC
