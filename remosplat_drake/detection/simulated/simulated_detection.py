"""`SimulatedDetection`: detects movers by cameras with latency and noise.

detection = SimulatedDetection(cameras, robot, known, config)
for each control tick:
    movers = detection.at(time, q, true_movers)
"""

import copy
import dataclasses as dc
from collections import deque
from collections.abc import Callable, Sequence

import numpy as np

from remosplat_drake.detection.detection_config import DetectionConfig
from remosplat_drake.detection.detection_state import DetectionState, add_image
from remosplat_drake.detection.known_scene import KnownScene
from remosplat_drake.detection.simulated.simulated_camera import (
    SimulatedCamera,
    SimulatedImage,
)
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.mover import Movers
from remosplat_drake.signals.distance_field import DistanceField

_EARLY = 1e-9
"""Rounding errors of times are below this limit [s]."""


@dc.dataclass(frozen=True, eq=False)
class PlacedCamera:
    """A simulated camera, with its pose and timing.

    Attributes:
        camera: The camera.
        pose: Function of the robot's configuration q that returns the camera's
            pose X_WC, shape (4, 4). If the camera is fixed in W, q has no
            effect.
        period: Time between two images of the camera [s].
        latency: Time from an image to its detections [s].
    """

    camera: SimulatedCamera
    pose: Callable[[np.ndarray], np.ndarray]
    period: float = 1 / 30
    latency: float = 0.04


class SimulatedDetection:
    """The cameras of a simulation, and the detection pipeline.

    The times of the cameras' first images are spread evenly over a period. An
    image has an effect only when its latency has passed.

    Args:
        cameras: The cameras.
        robot: The robot, which occludes objects and may be occluded.
        known: The map.
        config: Settings, with errors, margins and bounds.

    Attributes:
        detection: The state of detection.
    """

    def __init__(
        self,
        cameras: Sequence[PlacedCamera],
        robot: RobotModel,
        known: KnownScene,
        config: DetectionConfig,
    ):
        self._cameras = tuple(cameras)
        self._robot, self._known, self._config = robot, known, config
        n = len(cameras)
        self._due = [i * c.period / n for i, c in enumerate(cameras)]
        self._sent: deque[tuple[float, SimulatedImage, Spheres]] = deque()
        self._movers = Movers(0.0)
        self.detection = DetectionState()

    def __deepcopy__(self, memo) -> "SimulatedDetection":
        # Drake copies the whole state at every update of any part of it.
        other = copy.copy(self)
        other._cameras = copy.deepcopy(self._cameras, memo)
        other._due, other._sent = self._due.copy(), self._sent.copy()
        return other

    def learn(self, field: DistanceField) -> None:
        """Uses another map from now on.

        Args:
            field: The map.
        """
        if field.revision != self._known.revision:
            surface_W = self._known.surface_W
            self._known = KnownScene(field, self._config, surface_W)

    def at(self, time: float, q: np.ndarray, truth: Movers) -> Movers:
        """Advances to a time, and returns the movers that are known then.

        Args:
            time: The present time, which never decreases [s].
            q: The robot's configuration now, shape (n_q,).
            truth: The true movers now.

        Returns:
            The movers at the time of the newest processed image. There are none
            before the first image.
        """
        due = [i for i, t in enumerate(self._due) if t <= time + _EARLY]
        if due:
            spheres = self._robot.spheres_at(q)
            for i in due:
                placed = self._cameras[i]
                shot = placed.camera.take(placed.pose(q), time, truth, spheres)
                self._sent.append((time + placed.latency, shot, spheres))
                self._due[i] += placed.period
        news = False
        while self._sent and self._sent[0][0] <= time + _EARLY:
            _, shot, spheres = self._sent.popleft()
            self.detection = add_image(
                self.detection, shot.image, spheres, self._known, self._config
            )
            news = True
        if news:
            self._movers = self.detection.movers(self._config)
        return self._movers
