"""`RobotCamera`: a simulated wrist camera as a source of frames."""

import numpy as np
from pydrake.systems.framework import DiagramBuilder

from remosplat_drake.camera.camera_scene import CameraScene
from remosplat_drake.camera.mount import CameraMount
from remosplat_drake.camera.sources import place
from remosplat_drake.camera.station_camera import (
    camera_matrix,
    hand_eye,
    rgbd_image,
)
from remosplat_drake.camera.wrist_camera_config import WristCameraConfig
from remosplat_drake.capture.frames import Frame
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.signals import station_ports as ports


class RobotCamera:
    """Renders the true scene and the robot in it; then hides the robot.

    It is a `WristCamera` of the live map, and knows nothing of a simulation
    but the configurations that it is told.
    """

    def __init__(
        self,
        config: WristCameraConfig,
        robot: RobotModel,
        scene: PrimitiveScene | None,
    ):
        """Builds the scene and the camera.

        Args:
            config: The camera.
            robot: The robot that carries it.
            scene: What it sees.

        Raises:
            RemoSplatError: A setting is unusable.
        """
        self._config = config
        self._robot = robot
        self._K = camera_matrix(config)
        self._mount = CameraMount(robot, hand_eye(config), config.frame)
        self.show(scene)

    def show(self, scene: PrimitiveScene | None) -> None:
        """Changes what there is to see."""
        builder = DiagramBuilder()
        self._scene = CameraScene.AddToBuilder(
            builder, self._config, self._robot, scene
        )
        self._diagram = builder.Build()
        self._root = self._diagram.CreateDefaultContext()

    def listen(self) -> None:
        """Nothing arrives by itself."""

    def frame(self, q: np.ndarray, time: float) -> Frame:
        """What the camera sees at configuration q; see `WristCamera`."""
        self._scene.place(self._root, q, time)
        color, depth = (
            self._scene.images[name].Eval(self._camera_context)
            for name in (ports.WRIST_CAMERA_RGB, ports.WRIST_CAMERA_DEPTH)
        )
        image = rgbd_image(color, depth, self._K, time)
        return place(image, q, self._mount)

    @property
    def _camera_context(self):
        camera = self._scene.images[ports.WRIST_CAMERA_RGB].get_system()
        return camera.GetMyContextFromRoot(self._root)
