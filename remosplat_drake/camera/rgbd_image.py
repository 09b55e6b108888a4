"""`RgbdImage`: an image of any RGB-D camera, with its time."""

import dataclasses as dc

import numpy as np
from pydrake.systems.sensors import ImageDepth32F, ImageRgba8U

from remosplat_drake.capture.undistortion import Distortion


@dc.dataclass(frozen=True, eq=False)
class RgbdImage:
    """Colours and depths of one camera at one time, for the same pixels.

    It is immutable, so a deep copy is the object itself.

    Attributes:
        rgb: Colours, shape (h, w, 3), uint8.
        depth: Depth z in the camera frame C (OpenCV axes), shape (h, w),
            float32 [m]; 0 where it is unknown.
        K: Intrinsic matrix, shape (3, 3) [pixels]; the image's corner is at
            (0, 0), as in `Capture`.
        time: Time at which the image was taken, by the camera's clock [s].
        distortion: Distortion of the lens; None for a pinhole camera.
    """

    rgb: np.ndarray
    depth: np.ndarray
    K: np.ndarray
    time: float
    distortion: Distortion | None = None

    def __deepcopy__(self, memo) -> "RgbdImage":
        return self


def from_drake(
    color: ImageRgba8U, depth: ImageDepth32F, K: np.ndarray, time: float
) -> RgbdImage:
    """Converts images of Drake's `RgbdSensor` to an `RgbdImage`.

    Args:
        color: The colour image; its alpha channel is ignored.
        depth: The depth image [m]; depths out of the sensor's range, which
            Drake reports as 0 or inf, become unknown.
        K: Intrinsic matrix of both images, shape (3, 3) [pixels].
        time: Time at which the images were taken [s].
    """
    z = depth.data[..., 0]
    return RgbdImage(
        rgb=color.data[..., :3].copy(),
        depth=np.where(np.isfinite(z), z, np.float32(0)),
        K=K,
        time=time,
    )
