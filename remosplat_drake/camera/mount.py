"""`CameraMount`: a camera on the robot, its pose and what it sees of itself."""

import numpy as np
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.camera.robot_mask import robot_mask
from remosplat_drake.robot.model_file import add_robot_model
from remosplat_drake.robot.robot_model import RobotModel


class CameraMount:
    """A camera C fixed to a frame F of a robot.

    Attributes:
        robot: The robot; its spheres must cover it.
        X_FC: Hand-eye transform: the camera (OpenCV axes) in F, 4x4.
        margin: By which the robot's spheres are inflated [m].
    """

    def __init__(
        self,
        robot: RobotModel,
        X_FC: RigidTransform,
        frame: str = "wrist_camera",
        margin: float = 0.02,
    ):
        """Looks the frame up in the robot's model.

        Args:
            robot: The robot.
            X_FC: The hand-eye transform.
            frame: Name of F.
            margin: By which the robot's spheres are inflated [m].

        Raises:
            RemoSplatError: The robot has no such frame.
        """
        plant = MultibodyPlant(time_step=0.0)
        add_robot_model(robot.description, plant)
        plant.Finalize()
        if not plant.HasFrameNamed(frame):
            raise RemoSplatError(f"the robot has no frame {frame!r}")
        frame_F = plant.GetFrameByName(frame)
        self.robot = robot
        self.X_FC = X_FC.GetAsMatrix4()
        self.margin = margin
        self._body = robot.tree.index(frame_F.body().name())
        self._X_LF = frame_F.GetFixedPoseInBodyFrame().GetAsMatrix4()

    def pose(self, q: np.ndarray) -> np.ndarray:
        """The camera's pose X_WC at configuration q, a 4x4 matrix."""
        X_WL = self.robot.body_poses(q)[self._body]
        return X_WL @ self._X_LF @ self.X_FC

    def mask(
        self, q: np.ndarray, K: np.ndarray, depth: np.ndarray
    ) -> np.ndarray:
        """Pixels that may show the robot at q; see `robot_mask`."""
        spheres = self.robot.spheres_at(q)
        return robot_mask(spheres, K, self.pose(q), depth, self.margin)
