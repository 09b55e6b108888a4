"""`WireCamera`: simulates a depth camera that publishes over LCM."""

from collections.abc import Sequence
from time import sleep

import numpy as np
from pydrake.lcm import DrakeLcmInterface

from remosplat_drake.base.clock import MICROSECONDS, wall_utime
from remosplat_drake.detection.detection_camera_config import (
    DetectionCameraConfig,
)
from remosplat_drake.detection.simulated.simulated_camera import SimulatedCamera
from remosplat_drake.hardware.wire.images import encode_depth
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.moving.track import Track, movers_at
from remosplat_drake.scene.primitive_scene import PrimitiveScene


class WireCamera:
    """Renders depth images of scene, robot and movers, and publishes them.

    Rendering takes longer than a real camera needs for an image. But the
    simulation can predict motions, so it renders an image for a future time,
    ahead by `lead`, and sends the image at this time.

    Args:
        config: The camera.
        robot: The robot, as its spheres.
        scene: The static scene; None for an empty one.
        tracks: Tracks of the movers.
        lcm: The LCM network on which images are published.

    Attributes:
        lead: Time that is needed to render an image [us].
    """

    def __init__(
        self,
        config: DetectionCameraConfig,
        robot: RobotModel,
        scene: PrimitiveScene | None,
        tracks: Sequence[Track],
        lcm: DrakeLcmInterface,
    ):
        self._camera = SimulatedCamera(
            config.name,
            config.K,
            (config.height, config.width),
            scene,
            far=config.max_depth,
        )
        self._channel, self._pose = config.channel_name, config.pose(robot)
        self._robot, self._tracks, self._lcm = robot, tuple(tracks), lcm
        self.lead = 0

    def take(self, q: np.ndarray, utime: int, time: float) -> None:
        """Renders and publishes one depth image.

        Args:
            q: The robot's configuration, shape (n_q,).
            utime: Stamp of the image: wall clock of the Unix epoch [us].
            time: Time at which the movers' tracks are evaluated [s].
        """
        began = wall_utime()
        shot = self._camera.take(
            self._pose(q),
            time,
            movers_at(self._tracks, time),
            self._robot.spheres_at(q),
        )
        data = encode_depth(shot.image.depth, utime)
        self.lead = wall_utime() - began
        sleep(max(utime - wall_utime(), 0) / MICROSECONDS)
        self._lcm.Publish(self._channel, data)
