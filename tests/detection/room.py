"""A room with a table, and two cameras that look at it."""

import numpy as np
from pydrake.math import RigidTransform

from remosplat_drake.capture.rendering.sensor_noise import PRESETS
from remosplat_drake.detection.detection_config import DetectionConfig
from remosplat_drake.detection.detection_state import DetectionState, add_image
from remosplat_drake.detection.known_scene import KnownScene, surface_points
from remosplat_drake.detection.simulated.simulated_camera import SimulatedCamera
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.mover import Mover, Movers
from remosplat_drake.scene.primitive_scene import Box, Cylinder, PrimitiveScene

TABLE = Box(RigidTransform([0.9, 0, 0.3]), np.array([0.3, 0.5, 0.3]), "table")
CAN = Cylinder(RigidTransform([0.9, 0.2, 0.7]), 0.05, 0.1, "can")
ROOM = PrimitiveScene(boxes=(TABLE,), cylinders=(CAN,)).with_floor()
CONFIG = DetectionConfig()
SIZE = (60, 80)
K = np.array([[72.0, 0, 40], [0, 72.0, 30], [0, 0, 1]])
NOISE = PRESETS["realsense_d435"]
FRAME = 1 / 30
NO_ROBOT = Spheres.at(np.zeros((1, 3)), 0.1)


def looking(p_WC, at) -> np.ndarray:
    """The pose of a camera that looks from one place at another."""
    ahead = np.subtract(at, p_WC) / np.linalg.norm(np.subtract(at, p_WC))
    right = np.cross(ahead, [0, 0, 1])
    right /= np.linalg.norm(right)
    X_WC = np.eye(4)
    X_WC[:3, :3] = np.stack([right, np.cross(ahead, right), ahead], axis=1)
    X_WC[:3, 3] = p_WC
    return X_WC


LEFT = looking([-0.6, -1.4, 1.4], [0.5, 0, 0.7])
RIGHT = looking([-0.6, 1.4, 1.4], [0.5, 0, 0.7])


def known_room(config: DetectionConfig = CONFIG) -> KnownScene:
    """The room, as a map that knows it exactly."""
    return KnownScene(
        SignedDistanceField(ROOM), config, surface_points(None, ROOM)
    )


def camera(name="left", seed=0, noise=NOISE, scene=ROOM) -> SimulatedCamera:
    return SimulatedCamera(name, K, SIZE, scene, noise, seed)


def ball(p_W, v_W=(0, 0, 0), radius=0.12, time=0.0) -> Movers:
    v_WM = np.array(v_W, float)
    return Movers(time, [Mover.sphere("ball", p_W, radius, v_WM=v_WM)])


class Watch:
    """Cameras that take turns, and what is known by their images."""

    def __init__(self, poses, known=None, config=CONFIG, spheres=NO_ROBOT):
        self.poses = poses
        self.cameras = [camera(str(i), i) for i in range(len(poses))]
        self.known = known_room(config) if known is None else known
        self.config, self.spheres = config, spheres
        self.detection = DetectionState()

    def see(self, time, movers=None, which=0):
        """Takes the image of one camera; returns what is known by it."""
        shot = self.cameras[which].take(
            self.poses[which], time, movers, self.spheres
        )
        self.detection = add_image(
            self.detection, shot.image, self.spheres, self.known, self.config
        )
        return shot, self.detection.movers(self.config)
