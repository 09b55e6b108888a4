"""`WireDetection`: receives images over LCM, and sends the detected movers.

`remosplat detect` runs it in a separate process.
"""

import dataclasses as dc
import time as clock
from collections.abc import Callable, Sequence
from contextlib import suppress

import numpy as np

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.camera.motion_history import MotionHistory
from remosplat_drake.detection.depth_image import DepthImage
from remosplat_drake.detection.detection_camera_config import (
    DetectionCameraConfig,
)
from remosplat_drake.detection.detection_config import DetectionConfig
from remosplat_drake.detection.detection_state import (
    DetectionState,
    add_image,
    without_image,
)
from remosplat_drake.detection.followed_map import FollowedMap
from remosplat_drake.detection.known_scene import KnownScene
from remosplat_drake.detection.rehearsal import rehearse
from remosplat_drake.hardware.hardware_config import HardwareConfig
from remosplat_drake.hardware.wire.images import decode_depth
from remosplat_drake.hardware.wire.inbox import Inbox
from remosplat_drake.hardware.wire.movers import encode_movers
from remosplat_drake.hardware.wire.packets import BrokenMessage
from remosplat_drake.robot.robot_model import RobotModel

_AHEAD = 0.12
"""An image may be newer than the robot's latest status by at most this time
[s]. This is sufficient for bases that send ten statuses per second.
"""

_OLDEST = 0.5
"""An image is rejected if it is older than this time, or if its stamp is in the
future by more than this time [s].
"""


@dc.dataclass(frozen=True, eq=False)
class _Camera:
    config: DetectionCameraConfig
    K: np.ndarray
    pose: Callable[[np.ndarray], np.ndarray]


class WireDetection:
    """Receives images and robot statuses, and sends movers after every image.

    No movers are sent until every camera has sent an image and at least one
    image was usable. Otherwise an empty list of movers would mean that no
    movers exist, although parts of space were not observed.

    Args:
        cameras: The cameras.
        robot: The robot.
        known: The map.
        config: Settings, with errors, margins and bounds.
        hardware: The LCM URLs and the names of the channels.
        followed: The control loop's live map; None if `known` never changes.

    Attributes:
        detection: The state of detection.
        told: Number of messages that were sent.
        latency: Time from the latest image's stamp to its message [s].
        work: Computing time of this process for the latest message [s].

    Raises:
        RemoSplatError: The robot has no frame with the name in a camera's
            settings, or two cameras have the same channel.
    """

    def __init__(
        self,
        cameras: Sequence[DetectionCameraConfig],
        robot: RobotModel,
        known: KnownScene,
        config: DetectionConfig,
        hardware: HardwareConfig,
        followed: FollowedMap | None = None,
    ):
        rehearse(robot, known, config)
        self._robot, self._known, self._config = robot, known, config
        self._followed = followed
        self._cameras = {
            camera.channel_name: _Camera(camera, camera.K, camera.pose(robot))
            for camera in cameras
        }
        self._history = MotionHistory(len(robot.home), robot.n_base > 0)
        names = hardware.channels
        self._arm, self._base = names.arm_status, names.base_status
        self._movers, self._map = names.movers, names.counting_map
        self._lcm = hardware.open_lcm()
        self._packets = Inbox(self._lcm, [self._arm, self._base, self._map])
        self._images = Inbox(hardware.open_camera_lcm(), list(self._cameras))
        self.detection = DetectionState()
        self.told = 0
        self.latency = self.work = 0.0

    @property
    def missing(self) -> list[str]:
        """Names of the cameras that have not sent an image yet."""
        names = [camera.config.name for camera in self._cameras.values()]
        return [name for name in names if name not in self.detection.views]

    @property
    def problems(self) -> dict[str, str]:
        """Problems of cameras, keyed by the cameras' names."""
        told = self.detection.movers(self._config).cameras
        return {camera.name: camera.problem for camera in told}

    @property
    def map_in_use(self) -> str:
        """Returns a text that states the map in use and its problem, or ""."""
        followed = self._followed
        if followed is None:
            return ""
        number = followed.version
        text = (
            f"map {number} of the session" if number else "the scenario's map"
        )
        return f"{text}: {followed.trouble}" if followed.trouble else text

    def step(self, timeout: float = 0.01) -> bool:
        """Processes received packets, and sends movers if there was an image.

        Args:
            timeout: Longest wait for an image [s].

        Returns:
            Whether movers were sent.
        """
        # Of several waiting images of a camera, only the newest is used.
        newest = dict(self._images.fetch(timeout))
        started = clock.thread_time()
        for channel, data in self._packets.fetch():
            if channel == self._arm:
                self._history.hear_arm(data)
            elif channel == self._base:
                self._history.hear_base(data)
            elif self._followed is not None:
                self._hear_map(self._followed, data)
        if self._followed is not None:
            self._known = self._followed.at(clock.time())
        for channel, data in newest.items():
            self._take(self._cameras[channel], data)
        if not newest or self.missing or self.detection.time < 0:
            return False
        movers = self.detection.movers(self._config)
        self._lcm.Publish(self._movers, encode_movers(movers))
        self.told += 1
        self.latency = clock.time() - movers.stamp
        self.work = clock.thread_time() - started
        return True

    @staticmethod
    def _hear_map(followed: FollowedMap, data: bytes) -> None:
        """Receives the version of the map in use; ignores invalid packets."""
        with suppress(BrokenMessage):
            followed.hear(data, clock.time())

    def _take(self, camera: _Camera, data: bytes) -> None:
        """Processes an image, or records its problem."""
        config = camera.config
        blank = np.zeros((config.height, config.width), np.float32)
        X_WC = np.eye(4)
        stamp = clock.time()
        problem, depth = "", blank
        q = np.zeros(self._robot.n_q)
        try:
            depth, stamp = decode_depth(data)
            self._check(config, depth, stamp)
            q = self._history.at(stamp, _AHEAD)
            X_WC = camera.pose(q)
        except (BrokenMessage, RemoSplatError) as error:
            problem, depth, stamp = str(error), blank, clock.time()
        image = DepthImage(
            config.name,
            stamp,
            camera.K,
            X_WC,
            _within(depth, config),
            config.min_depth,
            config.max_depth,
        )
        if problem:
            self.detection = without_image(self.detection, image, problem)
            return
        spheres = self._robot.spheres_at(q)
        self.detection = add_image(
            self.detection, image, spheres, self._known, self._config
        )

    @staticmethod
    def _check(
        config: DetectionCameraConfig, depth: np.ndarray, stamp: float
    ) -> None:
        height, width = depth.shape
        if (width, height) != (config.width, config.height):
            raise RemoSplatError(
                f"sends {width}x{height} pixels; the scenario says"
                f" {config.width}x{config.height}"
            )
        age = clock.time() - stamp
        if not abs(age) < _OLDEST:
            when = "old" if age > 0 else "in the future"
            raise RemoSplatError(f"its images are {abs(age):.3g} s {when}")


def _within(depth: np.ndarray, config: DetectionCameraConfig) -> np.ndarray:
    """Limits depths to the camera's range; nearer depths become unknown."""
    near = np.where(depth >= config.min_depth, depth, np.float32(0))
    return np.where(near > config.max_depth, np.float32(np.inf), near)
