"""`CameraDriver`: publishes a camera's images over LCM."""

import contextlib
import time
from collections.abc import Callable
from typing import Protocol

from pydrake.lcm import DrakeLcmInterface

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.camera.rectification import Rectifier
from remosplat_drake.camera.rgbd_image import RgbdImage
from remosplat_drake.camera.wrist_camera_config import WristCameraConfig
from remosplat_drake.hardware.wire.channels import WRIST_CAMERA
from remosplat_drake.hardware.wire.images import encode_images
from remosplat_drake.hardware.wire.packets import to_utime

RETRY = 1.0
"""Time between two attempts to open a camera that was lost [s]."""


class Camera(Protocol):
    """A source of images, such as a `RealSenseCamera`."""

    def image(self) -> RgbdImage:
        """Waits for the next image; raises RemoSplatError if none comes."""
        ...

    def stop(self) -> None:
        """Releases the camera."""
        ...


class CameraDriver:
    """Publishes a camera's images, resampled to the scenario's camera.

    If the camera stops sending images, the driver closes it, and tries to
    reopen it until it sends images again.

    Attributes:
        sent: Number of sent images.
        problem: Reason why the camera sends no images at present; empty if it
            sends images.
    """

    def __init__(
        self,
        lcm: DrakeLcmInterface,
        config: WristCameraConfig,
        open_camera: Callable[[], Camera],
        channel: str = WRIST_CAMERA,
    ):
        """Opens the camera.

        Args:
            lcm: The LCM network on which images are published.
            config: Camera of the scenario, whose size and field of view
                receivers expect.
            open_camera: Function that opens the camera. It is called again
                after the camera stopped.
            channel: LCM channel of the images.

        Raises:
            RemoSplatError: The camera cannot be opened.
        """
        self._lcm, self._channel = lcm, channel
        self._rectified = Rectifier(config)
        self._open_camera = open_camera
        self._camera: Camera | None = open_camera()
        self.sent = 0
        self.problem = ""

    @property
    def coverage(self) -> float:
        """Fraction of the scenario's image that the camera's lens covers."""
        return self._rectified.coverage

    def step(self) -> None:
        """Sends the next image, or tries once to reopen a lost camera."""
        try:
            if self._camera is None:
                self._camera = self._open_camera()
            image = self._rectified(self._camera.image())
        except RemoSplatError as error:
            self.problem = str(error)
            self.close()
            time.sleep(RETRY)
            return
        self.problem = ""
        data = encode_images(image.rgb, image.depth, to_utime(image.time))
        self._lcm.Publish(self._channel, data)
        self.sent += 1

    def close(self) -> None:
        """Releases the camera."""
        camera, self._camera = self._camera, None
        if camera is not None:
            # An unplugged camera raises an error when it is stopped.
            with contextlib.suppress(RuntimeError):
                camera.stop()
