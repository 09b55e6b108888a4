"""`RenderedCamera`: a simulated wrist camera in the mapping process."""

from collections.abc import Sequence

import numpy as np
from pydrake.systems.framework import DiagramBuilder

from remosplat_drake.camera.camera_scene import CameraScene
from remosplat_drake.camera.mount import CameraMount
from remosplat_drake.camera.rgbd_image import from_drake
from remosplat_drake.camera.wrist_camera_config import WristCameraConfig
from remosplat_drake.capture.frames import Frame
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.moving.track import Track
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.signals import station_ports as ports


class RenderedCamera:
    """A `WristCamera` that renders the true scene, the robot and movers.

    The camera is in the mapping process. It receives only configurations and
    times from the simulation. The robot is masked in frames.
    """

    def __init__(
        self,
        config: WristCameraConfig,
        robot: RobotModel,
        scene: PrimitiveScene | None,
        odometry_drift: Sequence[float] = (0.0, 0.0, 0.0),
        tracks: Sequence[Track] = (),
    ):
        """Builds the scene and the camera.

        Args:
            config: Mount, lens and range of the camera.
            robot: The robot that carries it.
            scene: The solids in view besides the robot; None for none.
            odometry_drift: Velocity at which the received base poses drift from
                the true ones [m/s, m/s, rad/s].
            tracks: Motions of the movers over time.

        Raises:
            RemoSplatError: A setting is unusable.
        """
        self._config = config
        self._robot = robot
        self._drift = np.array(odometry_drift)
        self._tracks = tracks
        self._K = config.intrinsics().intrinsic_matrix()
        self._mount = CameraMount(robot, config.hand_eye(), config.frame)
        self.show(scene)

    def show(self, scene: PrimitiveScene | None) -> None:
        """Shows another scene from now on; None for an empty one."""
        builder = DiagramBuilder()
        self._scene = CameraScene.AddToBuilder(
            builder, self._config, self._robot, scene, self._tracks
        )
        self._diagram = builder.Build()
        self._root = self._diagram.CreateDefaultContext()

    def listen(self) -> None:
        """Does nothing: this camera receives nothing between frames."""

    def frame(self, q: np.ndarray, time: float) -> Frame:
        """Renders the camera's frame at a configuration.

        Args:
            q: The robot's configuration, shape (n_q,).
            time: Time of the frame, by the diagram's clock [s].
        """
        true_q = np.array(q, float)
        if self._robot.n_base:
            true_q[:3] -= self._drift * time
        self._scene.place(self._root, true_q, time, time)
        color, depth = (
            self._scene.images[name].Eval(self._camera_context)
            for name in (ports.WRIST_CAMERA_RGB, ports.WRIST_CAMERA_DEPTH)
        )
        return self._mount.frame(from_drake(color, depth, self._K, time), q)

    @property
    def _camera_context(self):
        camera = self._scene.images[ports.WRIST_CAMERA_RGB].get_system()
        return camera.GetMyContextFromRoot(self._root)
