"""`LcmCamera`: the real wrist camera as a source of frames."""

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
from remosplat_drake.camera.sources import RgbdImage, place
from remosplat_drake.camera.station_camera import (
    camera_matrix,
    hand_eye,
    rgbd_image,
)
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
"""A camera without an image for so long is silent [s]."""


class LcmCamera:
    """Listens to images and statuses; an image's pose is that of its stamp.

    It is a `WristCamera` of the live map. A frame is the first image that
    arrives after it was asked for, so that the robot may have come to rest.
    """

    def __init__(
        self,
        config: WristCameraConfig,
        robot: RobotModel,
        hardware: HardwareConfig,
    ):
        """Joins the wire.

        Args:
            config: The camera: intrinsics and hand-eye calibration.
            robot: The robot that carries it.
            hardware: Names the wire and its channels.

        Raises:
            RemoSplatError: A setting is unusable.
        """
        self._config = config
        self._mount = CameraMount(robot, hand_eye(config), config.frame)
        self._history = MotionHistory(len(robot.home), robot.n_base > 0)
        names = hardware.channels
        self._names = names
        self._inbox = Inbox(
            DrakeLcm(hardware.lcm_url),
            [names.wrist_camera, names.arm_status, names.base_status],
        )
        self._decoder = _Decoder()
        self._image: bytes | None = None

    def listen(self) -> None:
        """Takes in what has arrived."""
        for channel, data in self._inbox.fetch():
            if channel == self._names.wrist_camera:
                self._image = data
            elif channel == self._names.arm_status:
                self._history.hear_arm(data)
            else:
                self._history.hear_base(data)

    def show(self, scene: PrimitiveScene) -> None:
        """Cannot change the world.

        Raises:
            RemoSplatError: Always.
        """
        raise RemoSplatError("what a real camera sees cannot be changed")

    def frame(self, q: np.ndarray, time: float) -> Frame:
        """The next image; see `WristCamera`. Its pose is not taken from q."""
        asked = clock.time()
        image = self._next_image()
        self._hear_until(image.time)
        frame = place(image, self._history.at(image.time), self._mount)
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
    """Reads a message as Drake does, on a wire of its own."""

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
        return rgbd_image(color, depth, camera_matrix(config), stamp)
