"""`Frame`: one posed RGB-D image, and `assemble`, which makes captures.

Phones measure depth on a coarser grid than colour. All images of a capture have
the same size, so the larger image of a frame is shrunk to the size of the
smaller one. Colours are averaged over areas. Depths are taken from the nearest
pixel, because an interpolated depth between two surfaces belongs to neither.
"""

import dataclasses as dc
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from remosplat_drake.base.errors import FileError
from remosplat_drake.capture.capture import Capture, check_camera
from remosplat_drake.capture.images import shrink_colors
from remosplat_drake.capture.undistortion import Distortion, undistort

_ASPECT_TOLERANCE = 0.02
"""The aspect ratios of the colour image and the depth image of a frame may
differ by at most this fraction.
"""


@dc.dataclass(frozen=True, eq=False)
class Frame:
    """One RGB-D image of a camera C in a world frame W, as read from a file.

    Attributes:
        name: Name of the frame, which errors contain.
        K: Intrinsic matrix of the colour image, shape (3, 3) [pixels]; the
            first pixel has its centre at (0.5, 0.5).
        X_WC: Camera pose (OpenCV axes), shape (4, 4).
        rgb: sRGB colours, shape (h, w, 3), uint8.
        depth: Depth z in C, shape (h', w'), float32 [m]; 0 where unknown.
        hidden: Pixels that do not show the scene, shape (h", w"), bool, or
            None.
        distortion: Distortion of the lens; None for images of a pinhole camera.
        time: Time at which the image was taken [s]; None if unknown.
    """

    name: str
    K: np.ndarray
    X_WC: np.ndarray
    rgb: np.ndarray
    depth: np.ndarray
    hidden: np.ndarray | None = None
    distortion: Distortion | None = None
    time: float | None = None


def scale_intrinsics(
    K: np.ndarray, size: tuple[float, float], new_size: tuple[int, int]
) -> np.ndarray:
    """Scales an intrinsic matrix to a resized image.

    Args:
        K: Intrinsic matrix, shape (3, 3) [pixels].
        size: Height and width of the image before [pixels].
        new_size: Height and width of the resized image [pixels].
    """
    rows, columns = new_size[0] / size[0], new_size[1] / size[1]
    # `check_camera` rejects values that overflow in these products.
    with np.errstate(over="ignore", invalid="ignore"):
        return np.diag([columns, rows, 1.0]) @ K


def sample_nearest(image: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Resizes an image; each pixel is the nearest one of the given image.

    Args:
        image: Pixels of any type, shape (h, w, ...).
        size: Height and width of the result [pixels].
    """
    rows, columns = (
        ((np.arange(new) + 0.5) * old / new).astype(int)
        for new, old in zip(size, image.shape[:2], strict=True)
    )
    return image[rows[:, None], columns]


def assemble(
    path: Path,
    frames: Iterable[Frame],
    *,
    max_depth: float | None = None,
    max_size: int | None = None,
) -> Capture:
    """Makes a capture of frames, which are undistorted and get one size.

    Args:
        path: File or folder of the capture, which errors contain.
        frames: The frames, at least one.
        max_depth: Largest depth that is used [m]; the depth of more distant
            pixels becomes unknown.
        max_size: Largest width and height of images [pixels]; larger images are
            shrunk to this size.

    Raises:
        RemoSplatError: There is no frame, a frame has no usable camera, its
            colour and depth images differ in aspect ratio, or its images differ
            in size from those of earlier frames.
    """
    fitted: list[Frame] = []
    for frame in frames:
        fitted.append(_fit(path, frame, max_depth, max_size))
        first, last = fitted[0], fitted[-1]
        if last.depth.shape != first.depth.shape:
            raise FileError(
                path,
                f"images differ in size: {first.name} is"
                f" {_text(first.depth.shape)}, {last.name} is"
                f" {_text(last.depth.shape)}",
            )
    if not fitted:
        raise FileError(path, "has no frame with colour, depth and a pose")
    hidden = None
    if any(frame.hidden is not None for frame in fitted):
        shown = np.zeros(fitted[0].depth.shape, bool)
        hidden = np.array(
            [shown if f.hidden is None else f.hidden for f in fitted]
        )
    return Capture(
        K=np.array([frame.K for frame in fitted]),
        X_WC=np.array([frame.X_WC for frame in fitted]),
        rgb=np.array([frame.rgb for frame in fitted]),
        depth=np.array([frame.depth for frame in fitted]),
        hidden=hidden,
        names=tuple(frame.name for frame in fitted),
    )


def _fit(
    path: Path, frame: Frame, max_depth: float | None, max_size: int | None
) -> Frame:
    """Brings a frame's images to one size and removes the distortion."""
    check_camera(f"{path}: {frame.name}", frame.K, frame.X_WC)
    size = _common_size(path, frame, max_size)
    depth = sample_nearest(frame.depth, size)
    if (depth < 0).any():
        raise FileError(path, f"{frame.name}: depth must not be negative")
    if max_depth is not None:
        depth = np.where(depth > max_depth, np.float32(0), depth)
    hidden = frame.hidden
    fitted = dc.replace(
        frame,
        K=scale_intrinsics(frame.K, frame.rgb.shape[:2], size),
        rgb=shrink_colors(frame.rgb, size),
        depth=depth,
        hidden=None if hidden is None else sample_nearest(hidden, size),
    )
    if fitted.distortion is None or fitted.distortion == Distortion():
        return fitted
    rgb, depth, hidden = undistort(
        fitted.distortion, fitted.K, fitted.rgb, fitted.depth, fitted.hidden
    )
    return dc.replace(fitted, rgb=rgb, depth=depth, hidden=hidden)


def _common_size(
    path: Path, frame: Frame, max_size: int | None
) -> tuple[int, int]:
    """Height and width of the smaller one of a frame's two images."""
    color, depth = frame.rgb.shape[:2], frame.depth.shape
    if abs(color[1] * depth[0] / (color[0] * depth[1]) - 1) > _ASPECT_TOLERANCE:
        raise FileError(
            path,
            f"{frame.name}: colour ({_text(color)}) and depth"
            f" ({_text(depth)}) do not show the same view",
        )
    height, width = min(color, depth)
    shrink = 1.0 if max_size is None else max_size / max(height, width)
    if shrink >= 1:
        return height, width
    return max(1, round(height * shrink)), max(1, round(width * shrink))


def _text(size: tuple[int, ...]) -> str:
    return f"{size[1]}x{size[0]}"
