"""`CameraScene`: a robot and a scene that are rendered, never simulated."""

import dataclasses as dc
from collections.abc import Sequence

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import RigidBody
from pydrake.systems.framework import Context, DiagramBuilder, OutputPort

from remosplat_drake.camera.wrist_camera_config import WristCameraConfig
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.mover import Mover, Movers
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.station.dynamic_station import add_dynamic_body
from remosplat_drake.station.station_config import DynamicStation


@dc.dataclass(frozen=True, eq=False)
class CameraScene:
    """A plant that is only looked at, in a diagram that is never simulated.

    Both simulated cameras outside of a station's diagram render with it:
    `RenderedCamera` and `CameraSim`.

    Attributes:
        plant: The plant that poses robot and scene.
        joints: Index of each of the robot's positions in the plant's.
        movers: The bodies of what moves by itself.
        images: The camera's output ports by their names in
            `signals.station_ports`.
    """

    plant: MultibodyPlant
    joints: list[int]
    movers: Sequence[RigidBody]
    images: dict[str, OutputPort]

    @staticmethod
    def AddToBuilder(
        builder: DiagramBuilder,
        config: WristCameraConfig,
        robot: RobotModel,
        scene: PrimitiveScene | None,
        movers: Sequence[Mover] = (),
    ) -> "CameraScene":
        """Adds plant, scene graph and camera to a diagram.

        Args:
            builder: Builder of the diagram.
            config: Mount, lens and range of the camera.
            robot: The robot that carries it.
            scene: The solids that it sees besides the robot; None for none.
            movers: What moves, as it is at the start.

        Raises:
            RemoSplatError: A setting is unusable.
        """
        body = add_dynamic_body(
            builder, DynamicStation(), robot, scene, robot.q_home, movers
        )
        images = config.AddToStation(builder, body.plant, body.scene_graph)
        joints = [
            body.plant.GetJointByName(name).position_start()
            for name in robot.joint_names
        ]
        return CameraScene(body.plant, joints, body.movers, images)

    def place(
        self, root: Context, q: np.ndarray, time: float, movers: Movers
    ) -> None:
        """Poses the robot and what moves, and sets the images' time.

        Args:
            root: Context of the whole diagram.
            q: The robot's configuration, shape (n_q,).
            time: Time at which the images are taken [s].
            movers: What moves, as many as at the start and in their order.
        """
        root.SetTime(time)
        context = self.plant.GetMyMutableContextFromRoot(root)
        positions = self.plant.GetPositions(context)
        positions[self.joints] = q
        self.plant.SetPositions(context, positions)
        for body, mover in zip(self.movers, movers, strict=True):
            self.plant.SetFreeBodyPose(context, body, mover.X_WM)
