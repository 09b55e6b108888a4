"""`LcmCamera`: the wrist camera of the real robot, heard by LCM."""

import dataclasses as dc
import time as clock

import numpy as np
from drake import lcmt_image_array
from pydrake.lcm import DrakeLcm
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.lcm import LcmSubscriberSystem
from pydrake.systems.sensors import LcmImageArrayToImages

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.camera.motion_history import MotionHistory
from remosplat_drake.camera.mount import CameraMount
from remosplat_drake.camera.rgbd_image import RgbdImage, from_drake
from remosplat_drake.camera.wrist_camera_config import WristCameraConfig
from remosplat_drake.capture.frames import Frame
from remosplat_drake.hardware.hardware_config import HardwareConfig
from remosplat_drake.hardware.wire.channels import WRIST_CAMERA
from remosplat_drake.hardware.wire.inbox import Inbox
from remosplat_drake.hardware.wire.packets import (
    BrokenMessage,
    decode,
    from_utime,
)
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.primitive_scene import PrimitiveScene

PATIENCE = 2.0
"""Time without an image after which a camera counts as silent [s]."""


class LcmCamera:
    """A `WristCamera` that listens to images and to the robot's statuses.

    An image's pose follows from where the robot was at the image's stamp. A
    frame is the first image that arrives after it was asked for, so that the
    robot may have come to rest.
    """

    def __init__(
        self,
        config: WristCameraConfig,
        robot: RobotModel,
        hardware: HardwareConfig,
    ):
        """Joins the wire.

        Args:
            config: The camera's intrinsics and hand-eye transform.
            robot: The robot that carries it.
            hardware: The LCM URL and the names of the channels.

        Raises:
            RemoSplatError: A setting is unusable.
        """
        self._config = config
        self._mount = CameraMount(robot, config.hand_eye(), config.frame)
        self._history = MotionHistory(len(robot.home), robot.n_base > 0)
        names = hardware.channels
        self._names = names
        self._inbox = Inbox(
            hardware.open_lcm(),
            [names.wrist_camera, names.arm_status, names.base_status],
        )
        self._decoder = _Decoder()
        self._image: bytes | None = None

    def listen(self) -> None:
        """Takes in the images and statuses that have arrived."""
        for channel, data in self._inbox.fetch():
            if channel == self._names.wrist_camera:
                self._image = data
            elif channel == self._names.arm_status:
                self._history.hear_arm(data)
            else:
                self._history.hear_base(data)

    def show(self, scene: PrimitiveScene) -> None:
        """Refuses: what a real camera sees cannot be changed.

        Raises:
            RemoSplatError: Always.
        """
        raise RemoSplatError("what a real camera sees cannot be changed")

    def frame(self, q: np.ndarray, time: float) -> Frame:
        """Waits for the next image, and gives it its pose.

        Args:
            q: Not used: the pose follows from the statuses around the
                image's stamp.
            time: When the frame was asked for, by the diagram's clock [s].

        Returns:
            The frame, with its time by the diagram's clock [s].

        Raises:
            RemoSplatError: The camera is silent or sends something else, or
                the robot's statuses do not say where it was.
        """
        asked = clock.time()
        image = self._next_image()
        self._hear_until(image.time)
        frame = self._mount.frame(image, self._history.at(image.time))
        return dc.replace(frame, time=time + image.time - asked)

    def _next_image(self) -> RgbdImage:
        self.listen()
        self._image = None
        end = clock.monotonic() + PATIENCE
        while self._image is None:
            if clock.monotonic() > end:
                raise RemoSplatError("the wrist camera is silent")
            clock.sleep(0.002)
            self.listen()
        return self._decoder.image(self._image, self._config)

    def _hear_until(self, stamp: float) -> None:
        """Waits for the statuses that came after an image was taken."""
        end = clock.monotonic() + PATIENCE
        while self._history.newest <= stamp and clock.monotonic() < end:
            clock.sleep(0.002)
            self.listen()


class _Decoder:
    """Decodes and decompresses image messages with Drake's own systems."""

    def __init__(self):
        self._wire = DrakeLcm("memq://")
        builder = DiagramBuilder()
        subscriber = builder.AddSystem(
            LcmSubscriberSystem.Make(
                WRIST_CAMERA,
                lcmt_image_array,
                self._wire,
                use_cpp_serializer=True,
            )
        )
        self._images = builder.AddSystem(LcmImageArrayToImages())
        builder.Connect(
            subscriber.get_output_port(), self._images.get_input_port()
        )
        self._diagram = builder.Build()
        self._root = self._diagram.CreateDefaultContext()

    def image(self, data: bytes, config: WristCameraConfig) -> RgbdImage:
        """The image in a packet.

        Raises:
            RemoSplatError: It holds no colours and depths of one camera.
        """
        try:
            message = decode(lcmt_image_array, data)
        except BrokenMessage as error:
            raise RemoSplatError(f"the camera's message {error}") from error
        self._wire.Publish(WRIST_CAMERA, data)
        self._wire.HandleSubscriptions(0)
        self._diagram.ExecuteInitializationEvents(self._root)
        context = self._images.GetMyContextFromRoot(self._root)
        color, depth = (
            self._images.GetOutputPort(name).Eval(context)
            for name in ("color_image", "depth_image")
        )
        size = config.width, config.height
        for image in (color, depth):
            if (image.width(), image.height()) != size:
                raise RemoSplatError(
                    f"the camera sends {image.width()}x{image.height()}"
                    f" pixels; wrist_camera says {size[0]}x{size[1]}"
                )
        stamp = from_utime(message.header.utime)
        K = config.intrinsics().intrinsic_matrix()
        return from_drake(color, depth, K, stamp)
