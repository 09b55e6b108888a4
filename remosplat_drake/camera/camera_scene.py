"""`CameraScene`: the robot among what it sees, to be rendered."""

import dataclasses as dc

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import Context, DiagramBuilder, OutputPort

from remosplat_drake.camera.wrist_camera_config import WristCameraConfig
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.station.dynamic_station import add_dynamic_body
from remosplat_drake.station.station_config import DynamicStation


@dc.dataclass(frozen=True, eq=False)
class CameraScene:
    """A plant that is only looked at, in a diagram that is never simulated.

    Attributes:
        plant: Poses robot and scene.
        joints: Index of each of the robot's positions in the plant's.
        images: The camera's ports, by the station's names.
    """

    plant: MultibodyPlant
    joints: list[int]
    images: dict[str, OutputPort]

    @staticmethod
    def AddToBuilder(
        builder: DiagramBuilder,
        config: WristCameraConfig,
        robot: RobotModel,
        scene: PrimitiveScene | None,
    ) -> "CameraScene":
        """Adds the plant and the camera.

        Args:
            builder: Of the diagram.
            config: The camera.
            robot: The robot that carries it.
            scene: What it sees.

        Raises:
            RemoSplatError: A setting is unusable.
        """
        q = np.zeros(robot.n_q)
        q[robot.n_q - len(robot.home) :] = robot.home
        body = add_dynamic_body(builder, DynamicStation(), robot, scene, q)
        images = config.AddToStation(builder, body.plant, body.scene_graph)
        joints = [
            body.plant.GetJointByName(name).position_start()
            for name in robot.joint_names
        ]
        return CameraScene(body.plant, joints, images)

    def place(self, root: Context, q: np.ndarray, time: float) -> None:
        """Puts the robot somewhere.

        Args:
            root: The diagram's context.
            q: The robot's configuration, shape (n_q,).
            time: Stamp of the images [s].
        """
        root.SetTime(time)
        context = self.plant.GetMyMutableContextFromRoot(root)
        positions = self.plant.GetPositions(context)
        positions[self.joints] = q
        self.plant.SetPositions(context, positions)
