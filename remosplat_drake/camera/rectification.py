"""`Rectifier`: converts images of a real lens to those of a pinhole camera."""

import numpy as np

from remosplat_drake.camera.rgbd_image import RgbdImage
from remosplat_drake.camera.wrist_camera_config import WristCameraConfig
from remosplat_drake.capture.undistortion import (
    Distortion,
    distort,
    valid_radius,
)


class Rectifier:
    """Resamples a camera's images to those of the scenario's pinhole camera.

    This is necessary because messages describe a camera only by size and field
    of view. Each pixel of the result has the colour and depth of the nearest
    pixel of the real image, which is at most half a pixel from the ray. Pixels
    outside the field of view of the lens are black, and their depths are
    unknown.
    """

    def __init__(self, config: WristCameraConfig):
        """Stores the camera of the scenario.

        Args:
            config: Settings of the scenario's camera.
        """
        self._config = config
        self._lens: tuple | None = None
        self._pixels = np.zeros(0, int)
        self._outside = np.zeros((0, 0), bool)

    def __call__(self, image: RgbdImage) -> RgbdImage:
        """Returns the image of the scenario's camera.

        Args:
            image: An image, with its intrinsics and distortion.
        """
        lens = image.K.tobytes(), image.distortion, image.depth.shape
        if lens != self._lens:
            self._lens = lens
            self._look_up(image)
        height, width = self._outside.shape
        rgb = image.rgb.reshape(-1, 3)[self._pixels]
        depth = image.depth.ravel()[self._pixels]
        rgb[self._outside], depth[self._outside] = 0, 0
        return RgbdImage(
            rgb=rgb.reshape(height, width, 3),
            depth=depth,
            K=self._config.intrinsics().intrinsic_matrix(),
            time=image.time,
        )

    @property
    def coverage(self) -> float:
        """Fraction of the scenario's image that the latest image covered."""
        return 1.0 - float(self._outside.mean()) if self._outside.size else 0.0

    def _look_up(self, image: RgbdImage) -> None:
        """Finds the pixel of the real image for each pixel of the result."""
        config, distortion = self._config, image.distortion or Distortion()
        K = config.intrinsics().intrinsic_matrix()
        u, v = np.meshgrid(
            np.arange(config.width) + 0.5, np.arange(config.height) + 0.5
        )
        xy = np.stack([u - K[0, 2], v - K[1, 2]], axis=-1) / K[[0, 1], [0, 1]]
        seen = distort(distortion, xy) * image.K[[0, 1], [0, 1]]
        nearest = np.floor(seen + image.K[:2, 2]).astype(int)
        column, row = nearest[..., 0], nearest[..., 1]
        height, width = image.depth.shape
        beyond = np.linalg.norm(xy, axis=-1) > valid_radius(distortion)
        self._outside = (
            beyond
            | (column < 0)
            | (column >= width)
            | (row < 0)
            | (row >= height)
        )
        self._pixels = np.where(self._outside, 0, row * width + column)
