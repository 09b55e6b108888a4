"""`LcmCamera`: receives a real wrist camera's images over LCM."""

import time as clock
from collections.abc import Sequence

import numpy as np

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.camera.motion_history import MotionHistory
from remosplat_drake.camera.mount import CameraMount
from remosplat_drake.camera.rgbd_image import RgbdImage
from remosplat_drake.camera.wrist_camera_config import WristCameraConfig
from remosplat_drake.capture.frames import Frame
from remosplat_drake.hardware.hardware_config import HardwareConfig
from remosplat_drake.hardware.wire.images import CameraImages, decode_images
from remosplat_drake.hardware.wire.inbox import Inbox
from remosplat_drake.hardware.wire.packets import BrokenMessage
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.objects.placed_object import PlacedObject
from remosplat_drake.scene.primitive_scene import PrimitiveScene

PATIENCE = 2.0
"""A camera without an image for this time has stopped sending [s]."""


class LcmCamera:
    """A `WristCamera` that receives images and the robot's statuses.

    An image's pose is computed from the robot's configuration at the image's
    stamp. `frame` returns the first image that arrives after the call. So if
    the robot is at rest at the call, it is at rest in the image.

    Attributes:
        broken: Number of broken images so far.
        problem: Problem of the latest broken image; empty if no image was
            broken.
    """

    def __init__(
        self,
        config: WristCameraConfig,
        robot: RobotModel,
        hardware: HardwareConfig,
    ):
        """Subscribes to the channels.

        Args:
            config: The camera's intrinsics and hand-eye transform.
            robot: The robot that carries the camera.
            hardware: The LCM URL and the names of the channels.

        Raises:
            RemoSplatError: A setting is invalid.
        """
        self._config = config
        self._mount = CameraMount(robot, config.hand_eye(), config.frame)
        self._history = MotionHistory(len(robot.home), robot.n_base > 0)
        names = hardware.channels
        self._names = names
        self._statuses = Inbox(
            hardware.open_lcm(), [names.arm_status, names.base_status]
        )
        self._images = Inbox(hardware.open_camera_lcm(), [names.wrist_camera])
        self._image: CameraImages | None = None
        self.broken = 0
        self.problem = ""

    def listen(self) -> None:
        """Processes the images and statuses that have arrived."""
        for _, data in self._images.fetch():
            try:
                self._image = decode_images(data)
            except BrokenMessage as error:
                self.broken += 1
                self.problem = f"{self._names.wrist_camera}: {error}"
        for channel, data in self._statuses.fetch():
            if channel == self._names.arm_status:
                self._history.hear_arm(data)
            else:
                self._history.hear_base(data)

    def place(self, objects: Sequence[PlacedObject]) -> None:
        """Does nothing, since a real camera sees the objects where they are."""

    def show(self, scene: PrimitiveScene) -> None:
        """Raises an error: the view of a real camera cannot be changed.

        Raises:
            RemoSplatError: Always.
        """
        raise RemoSplatError("the view of a real camera cannot be changed")

    def frame(self, q: np.ndarray, time: float) -> Frame:
        """Waits for the next image, and computes its pose.

        Args:
            q: Not used, since the pose follows from the robot's statuses around
                the image's time stamp.
            time: Not used, since the image's time stamp is by the wall clock,
                like the time of a real robot's diagram.

        Returns:
            The frame, with its time by the wall clock [s].

        Raises:
            RemoSplatError: The camera has stopped sending, its images are
                broken or of another size, or the robot's statuses do not
                determine its pose.
        """
        image = self._next_image()
        self._hear_until(image.time)
        return self._mount.frame(image, self._history.at(image.time))

    def _next_image(self) -> RgbdImage:
        self.listen()
        self._image, broken = None, self.broken
        end = clock.monotonic() + PATIENCE
        while self._image is None:
            if clock.monotonic() > end:
                count = self.broken - broken
                raise RemoSplatError(
                    f"{count} broken images in a row, the last one on"
                    f" {self.problem}"
                    if count
                    else "the wrist camera sends no images: check its driver"
                )
            clock.sleep(0.002)
            self.listen()
        return self._rgbd(self._image)

    def _rgbd(self, images: CameraImages) -> RgbdImage:
        config, (height, width) = self._config, images.depth.shape
        if (width, height) != (config.width, config.height):
            raise RemoSplatError(
                f"the camera sends {width}x{height} pixels; wrist_camera has"
                f" {config.width}x{config.height}"
            )
        known = np.isfinite(images.depth)
        return RgbdImage(
            rgb=images.rgb,
            depth=np.where(known, images.depth, np.float32(0)),
            K=config.intrinsics().intrinsic_matrix(),
            time=images.stamp,
        )

    def _hear_until(self, stamp: float) -> None:
        """Waits for statuses that are newer than an image."""
        end = clock.monotonic() + PATIENCE
        while self._history.newest <= stamp and clock.monotonic() < end:
            clock.sleep(0.002)
            self.listen()
