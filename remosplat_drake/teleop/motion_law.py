"""`MotionLaw`: what the target's motion goes by besides the operator."""

import dataclasses as dc

import numpy as np

from remosplat_drake.camera.mount import CameraMount
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.teleop.teleop_config import TeleopConfig


@dc.dataclass(frozen=True, eq=False)
class MotionLaw:
    """What the target's motion goes by besides the operator.

    Attributes:
        config: Its bounds, and the saved poses.
        X_WT_home: Where home is, shape (4, 4).
        dt: Length of a step [s].
        X_EC: The wrist camera (OpenCV axes) on the end effector; None
            without one, and then there is no scan.
        frames: Number of frames of a scan.
    """

    config: TeleopConfig
    X_WT_home: np.ndarray
    dt: float
    X_EC: np.ndarray | None = None
    frames: int = 8

    @staticmethod
    def make(
        config: TeleopConfig,
        robot: RobotModel,
        q0: np.ndarray,
        dt: float,
        mount: CameraMount | None = None,
        frames: int = 8,
    ) -> "MotionLaw":
        """The law of a robot whose home is where it starts.

        Args:
            config: See the attribute.
            robot: Finds the end effector.
            q0: Configuration to start from, shape (n_q,).
            dt: See the attribute.
            mount: The wrist camera; it must move with the end effector.
            frames: See the attribute.
        """
        X_WE = robot.end_effector_pose(q0)
        X_EC = None
        if mount is not None:
            X_EC = np.linalg.inv(X_WE) @ mount.pose(q0)
        return MotionLaw(config, X_WE, dt, X_EC, frames)
