"""`NewPoints`: points in a depth image that belong to neither map nor robot."""

import dataclasses as dc

import numpy as np

from remosplat_drake.detection.depth_image import DepthImage
from remosplat_drake.detection.detection_config import DetectionConfig
from remosplat_drake.detection.kernels.scan import scan
from remosplat_drake.detection.known_scene import NODE, KnownScene
from remosplat_drake.robot.sphere_model import Spheres


@dc.dataclass(frozen=True, eq=False)
class NewPoints:
    """Points that a camera sees and that the map does not contain.

    There are n points.

    Attributes:
        p_W: Positions of the points in W, shape (n, 3) [m].
        depth: Depths z of the points in the camera's frame, shape (n,) [m].
        pitch: Distance between neighbouring examined pixels, at a depth of one
            metre [m].
        p_WC: Position of the camera, shape (3,) [m].
        time: Time of the image [s].
    """

    p_W: np.ndarray
    depth: np.ndarray
    pitch: float
    p_WC: np.ndarray
    time: float

    def __len__(self) -> int:
        return len(self.depth)

    @staticmethod
    def none(image: DepthImage) -> "NewPoints":
        """Makes an empty set of points for an image."""
        return NewPoints(
            np.zeros((0, 3)), np.zeros(0), 0.0, image.p_WC, image.time
        )


def find_new(
    image: DepthImage,
    spheres: Spheres,
    scene: KnownScene,
    config: DetectionConfig,
) -> NewPoints:
    """Finds the new points in an image.

    A point is not new in four cases. First, it is on a surface of the map, up
    to the errors of depth and camera pose. Second, it is on the robot, or its
    line of sight passes through the robot. Third, it is on the floor. Fourth,
    its depth differs from those of all neighbouring pixels, as at the edges of
    objects.

    Args:
        image: The depth image.
        spheres: The robot's spheres in W when the image was taken.
        scene: The map.
        config: Settings, with errors and margins.
    """
    stride = image.stride(config.columns)
    height, width = image.depth.shape
    most = (height // stride + 1) * (width // stride + 1)
    found, asked = np.empty((most, 4)), np.empty(8 * most, np.int64)
    rules = np.array(
        [
            config.range,
            config.depth_error,
            config.depth_growth,
            config.sigmas,
            config.pose_error,
            config.robot_margin,
            config.floor_height,
        ]
    )
    while True:
        _, n_asked, n_found = scan(
            image.depth,
            image.K,
            image.X_WC,
            stride,
            scene.nodes,
            scene.lower,
            NODE,
            rules,
            image.balls(spheres),
            asked,
            found,
        )
        if not n_asked:
            break
        scene.ask(asked[:n_asked])
    return NewPoints(
        found[:n_found, :3].copy(),
        found[:n_found, 3].copy(),
        stride / float(image.K[0, 0]),
        image.p_WC,
        image.time,
    )
