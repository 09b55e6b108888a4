"""`RenderedCamera`: the simulated wrist camera of the mapping process."""

import dataclasses as dc
from collections.abc import Mapping, Sequence
from typing import TypeVar

import numpy as np
from pydrake.math import RigidTransform
from pydrake.systems.framework import DiagramBuilder

from remosplat_drake.camera.camera_scene import CameraScene
from remosplat_drake.camera.mount import CameraMount
from remosplat_drake.camera.rgbd_image import from_drake
from remosplat_drake.camera.wrist_camera_config import WristCameraConfig
from remosplat_drake.capture.frames import Frame
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.moving.track import Track
from remosplat_drake.scene.objects.placed_object import PlacedObject
from remosplat_drake.scene.primitive_scene import Box, Cylinder, PrimitiveScene
from remosplat_drake.signals import station_ports as ports

Solid = TypeVar("Solid", Box, Cylinder)


class RenderedCamera:
    """A `WristCamera` that renders the true scene, the robot and movers.

    The camera runs in the mapping process, and receives only configurations and
    times from the simulation. In its frames, the robot is masked.
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
            robot: The robot that carries the camera.
            scene: The solids of the scene; None for an empty scene.
            odometry_drift: Velocity at which the received base poses drift from
                the true ones [m/s, m/s, rad/s].
            tracks: Motions of the movers (moving objects) over time.

        Raises:
            RemoSplatError: A setting is invalid.
        """
        self._config = config
        self._robot = robot
        self._drift = np.array(odometry_drift)
        self._tracks = tracks
        self._K = config.intrinsics().intrinsic_matrix()
        self._mount = CameraMount(robot, config.hand_eye(), config.frame)
        self.show(scene)

    def show(self, scene: PrimitiveScene | None) -> None:
        """Renders another scene from now on; None is an empty scene."""
        self._shown = scene
        builder = DiagramBuilder()
        self._scene = CameraScene.AddToBuilder(
            builder, self._config, self._robot, scene, self._tracks
        )
        self._diagram = builder.Build()
        self._root = self._diagram.CreateDefaultContext()

    def place(self, objects: Sequence[PlacedObject]) -> None:
        """Moves the solids of the scene that have the names of objects.

        Args:
            objects: The objects at their present poses.
        """
        poses = {each.name: each.X_WO for each in objects}
        scene = self._shown
        if scene is None or not poses:
            return
        moved = dc.replace(
            scene,
            boxes=tuple(_moved(x, poses) for x in scene.boxes),
            cylinders=tuple(_moved(x, poses) for x in scene.cylinders),
        )
        if any(
            a is not b
            for a, b in zip(moved.primitives, scene.primitives, strict=True)
        ):
            self.show(moved)

    def listen(self) -> None:
        """Does nothing, since this camera receives no messages."""

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


def _moved(solid: Solid, poses: Mapping[str, np.ndarray]) -> Solid:
    """The solid at the pose of its object; unchanged if it is already there."""
    X_WP = poses.get(solid.name)
    if X_WP is None or np.allclose(solid.X_WP.GetAsMatrix4(), X_WP):
        return solid
    return dc.replace(solid, X_WP=RigidTransform(X_WP))
