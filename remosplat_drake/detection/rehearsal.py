"""Compiles the kernels of detection, by processing synthetic images."""

import numpy as np

from remosplat_drake.detection.depth_image import DepthImage
from remosplat_drake.detection.detection_config import DetectionConfig
from remosplat_drake.detection.detection_state import DetectionState, add_image
from remosplat_drake.detection.known_scene import KnownScene
from remosplat_drake.robot.robot_model import RobotModel

_AWAY = 1.0
"""Distance of the cameras from the robot's highest sphere [m]."""

_SIDE, _FOCAL = 24, 30.0
"""Width and height of the cameras' images, and their focal length [pixels]."""


def rehearse(
    robot: RobotModel, known: KnownScene, config: DetectionConfig
) -> None:
    """Processes images of an object that appears near the robot and vanishes.

    Two simulated cameras take these images. Numba loads or compiles kernels
    once per process. Without this call, it would do so during operation, and
    detection would stop for this time.

    Args:
        robot: The robot that the cameras will see.
        known: The map. Distances near one point are computed and stored in it.
        config: Settings, with errors, margins and bounds.
    """
    known.distances(known.lower[None])
    spheres = robot.spheres_at(robot.q_home)
    nothing, detection = KnownScene(None, config), DetectionState()
    X_WC = np.eye(4)
    X_WC[:3, :3] = [[0, 0, 1], [-1, 0, 0], [0, -1, 0]]  # It looks along x.
    highest = spheres.p_WS[spheres.p_WS[:, 2].argmax()]
    X_WC[:3, 3] = highest - [_AWAY, 0, 0]
    middle = 0.5 * _SIDE
    K = np.array([[_FOCAL, 0, middle], [0, _FOCAL, middle], [0, 0, 1.0]])
    for i in range(6):
        depth = np.full((_SIDE, _SIDE), np.inf, np.float32)
        depth[6:18, 6 : 18 - 2 * i] = 0.8 * _AWAY
        image = DepthImage(f"rehearsal {i % 2}", 0.08 * i, K, X_WC, depth)
        detection = add_image(detection, image, spheres, nothing, config)
        detection.movers(config)
