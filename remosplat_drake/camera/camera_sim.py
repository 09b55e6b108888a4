"""`CameraSim`: simulates the wrist camera's LCM driver.

`remosplat camera-sim` runs it in a separate process, beside `hardware-sim`.
"""

import contextlib
from collections.abc import Sequence

import numpy as np
from drake import lcmt_image_array
from pydrake.lcm import DrakeLcmInterface
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.lcm import LcmPublisherSystem
from pydrake.systems.sensors import ImageToLcmImageArrayT, PixelType

from remosplat_drake.base.clock import MICROSECONDS
from remosplat_drake.camera.camera_scene import CameraScene
from remosplat_drake.camera.wrist_camera_config import WristCameraConfig
from remosplat_drake.hardware.wire.base import decode_base_status
from remosplat_drake.hardware.wire.channels import (
    BASE_STATUS,
    PANDA_STATUS,
    WRIST_CAMERA,
)
from remosplat_drake.hardware.wire.packets import BrokenMessage
from remosplat_drake.hardware.wire.panda import decode_panda_status
from remosplat_drake.robot.robot_description import RobotDescription
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.moving.track import Track
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.signals import station_ports as ports


class CameraSim:
    """Renders the wrist camera's images and publishes them by LCM.

    Images are compressed, since uncompressed images exceed the usual buffers of
    sockets.
    """

    def __init__(
        self,
        config: WristCameraConfig,
        robot: RobotModel,
        scene: PrimitiveScene | None,
        tracks: Sequence[Track],
        lcm: DrakeLcmInterface,
    ):
        """Builds the scene and the camera.

        Args:
            config: Mount, lens and range of the camera.
            robot: The robot that carries the camera.
            scene: The solids of the scene; None for an empty scene.
            tracks: Motions of the movers over time.
            lcm: The LCM network on which the images are published.

        Raises:
            RemoSplatError: A setting is invalid.
        """
        builder = DiagramBuilder()
        self._scene = CameraScene.AddToBuilder(
            builder, config, robot, scene, tracks
        )
        images = self._scene.images
        message = builder.AddSystem(ImageToLcmImageArrayT(do_compress=True))
        self._publisher = builder.AddSystem(
            LcmPublisherSystem.Make(
                WRIST_CAMERA,
                lcmt_image_array,
                lcm,
                use_cpp_serializer=True,
            )
        )
        color = message.DeclareImageInputPort[PixelType.kRgba8U]("color")
        depth = message.DeclareImageInputPort[PixelType.kDepth32F]("depth")
        builder.Connect(images[ports.WRIST_CAMERA_RGB], color)
        builder.Connect(images[ports.WRIST_CAMERA_DEPTH], depth)
        builder.Connect(
            message.image_array_t_msg_output_port(),
            self._publisher.get_input_port(),
        )
        self._root = builder.Build().CreateDefaultContext()

    def take(self, q: np.ndarray, utime: int, time: float) -> None:
        """Renders and publishes one colour and one depth image.

        Args:
            q: The robot's configuration, shape (n_q,).
            utime: Stamp of the images: wall clock of the Unix epoch [us].
            time: Time since the movers began to move [s].
        """
        self._scene.place(self._root, q, utime / MICROSECONDS, time)
        context = self._publisher.GetMyContextFromRoot(self._root)
        self._publisher.ForcedPublish(context)


_MOVED = 5e-3
"""The robot has moved if any of its positions has changed by more than this [m,
rad]."""


class HeardConfiguration:
    """The robot's latest configuration, assembled from LCM statuses.

    Simulated movers start when the robot first moves. So all processes that
    receive the robot's statuses from before this motion compute the same start
    time.

    Attributes:
        channels: The LCM channels whose messages this object must receive.
    """

    def __init__(self, description: RobotDescription):
        """Starts without any status.

        Args:
            description: The robot, with or without a mobile base.
        """
        self._has_base = description.base is not None
        self._n = len(description.arm.joints)
        self._pose = None if self._has_base else np.zeros(0)
        self._joints: np.ndarray | None = None
        self._first: np.ndarray | None = None
        self._began: float | None = None
        base = [BASE_STATUS] if self._has_base else []
        self.channels = [*base, PANDA_STATUS]

    def receive(self, channel: str, data: bytes) -> None:
        """Processes a message; ignores broken messages and other channels.

        Args:
            channel: The LCM channel of the message.
            data: The encoded message.
        """
        with contextlib.suppress(BrokenMessage):
            if channel == BASE_STATUS and self._has_base:
                base = decode_base_status(data)
                self._pose = base.pose
                self._watch(base.stamp)
            elif channel == PANDA_STATUS:
                arm = decode_panda_status(data, self._n)
                self._joints = arm.q
                self._watch(arm.stamp)

    def _watch(self, stamp: float) -> None:
        """Records when the robot first leaves its initial configuration."""
        q = self.q
        if q is None or self._began is not None:
            return
        if self._first is None:
            self._first = q
        elif np.abs(q - self._first).max() > _MOVED:
            self._began = stamp

    def time_at(self, utime: int) -> float:
        """Returns the time since the robot began to move, 0 before that [s].

        Args:
            utime: Wall clock of the Unix epoch [us].
        """
        if self._began is None:
            return 0.0
        return max(utime / MICROSECONDS - self._began, 0.0)

    @property
    def q(self) -> np.ndarray | None:
        """Configuration (x, y, yaw, arm), shape (n_q,) [m, rad].

        It is None until the arm, and the base if there is one, have sent a
        status.
        """
        if self._pose is None or self._joints is None:
            return None
        return np.concatenate([self._pose, self._joints])
