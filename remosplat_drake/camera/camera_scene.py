"""`CameraScene`: a plant with robot and scene that is only rendered."""

import dataclasses as dc
from collections.abc import Sequence

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import RigidBody
from pydrake.systems.framework import Context, DiagramBuilder, OutputPort

from remosplat_drake.camera.wrist_camera_config import WristCameraConfig
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.moving.track import Track, movers_at
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.station.dynamic_station import add_dynamic_body
from remosplat_drake.station.station_config import DynamicStation


@dc.dataclass(frozen=True, eq=False)
class CameraScene:
    """A plant with robot and scene that is rendered but not simulated.

    The simulated cameras that are not part of a station's diagram use it:
    `RenderedCamera` and `CameraSim`.

    Attributes:
        plant: The plant with robot and scene.
        joints: Index of each position of the robot in the plant's positions.
        tracks: Motions of the movers over time.
        movers: The bodies of the movers in the plant, in the order of `tracks`.
        images: The camera's output ports by their names in
            `signals.station_ports`.
    """

    plant: MultibodyPlant
    joints: list[int]
    tracks: Sequence[Track]
    movers: Sequence[RigidBody]
    images: dict[str, OutputPort]

    @staticmethod
    def AddToBuilder(
        builder: DiagramBuilder,
        config: WristCameraConfig,
        robot: RobotModel,
        scene: PrimitiveScene | None,
        tracks: Sequence[Track] = (),
    ) -> "CameraScene":
        """Adds plant, scene graph and camera to a diagram.

        Args:
            builder: Builder of the diagram.
            config: Mount, lens and range of the camera.
            robot: The robot that carries the camera.
            scene: The solids of the scene; None for an empty scene.
            tracks: Motions of the movers over time.

        Raises:
            RemoSplatError: A setting is invalid.
        """
        start = list(movers_at(tracks, 0.0))
        body = add_dynamic_body(
            builder, DynamicStation(), robot, scene, robot.q_home, start
        )
        images = config.AddToStation(builder, body.plant, body.scene_graph)
        joints = [
            body.plant.GetJointByName(name).position_start()
            for name in robot.joint_names
        ]
        return CameraScene(body.plant, joints, tracks, body.movers, images)

    def place(
        self, root: Context, q: np.ndarray, stamp: float, time: float
    ) -> None:
        """Poses the robot and the movers, and sets the images' time.

        Args:
            root: Context of the whole diagram.
            q: The robot's configuration, shape (n_q,).
            stamp: Time at which the images are taken [s].
            time: Time at which the movers' tracks are evaluated [s].
        """
        root.SetTime(stamp)
        context = self.plant.GetMyMutableContextFromRoot(root)
        positions = self.plant.GetPositions(context)
        positions[self.joints] = q
        self.plant.SetPositions(context, positions)
        movers = movers_at(self.tracks, time)
        for body, mover in zip(self.movers, movers, strict=True):
            self.plant.SetFreeBodyPose(context, body, mover.X_WM)
