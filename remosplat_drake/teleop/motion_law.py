"""`MotionLaw`: bounds and settings of the target's motion."""

import dataclasses as dc

import numpy as np

from remosplat_drake.camera.mount import CameraMount
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.target import Target
from remosplat_drake.signals.target_state import HOLD, SCAN, TargetState
from remosplat_drake.teleop.teleop_config import TeleopConfig


@dc.dataclass(frozen=True, eq=False)
class MotionLaw:
    """Bounds and settings of the target's motion, constant during a run.

    Attributes:
        config: Bounds of the motion, and the saved poses.
        X_WT_home: Pose of the target at home, shape (4, 4).
        dt: Time between two steps of the target [s].
        X_EC: Pose of the wrist camera (OpenCV axes) in the end effector's
            frame, shape (4, 4); None if there is no camera, so that scans are
            impossible.
        frames: Number of frames of a scan.
        effector: Index of the end effector that is teleoperated.
    """

    config: TeleopConfig
    X_WT_home: np.ndarray
    dt: float
    X_EC: np.ndarray | None = None
    frames: int = 8
    effector: int = 0

    @staticmethod
    def make(
        config: TeleopConfig,
        robot: RobotModel,
        q0: np.ndarray,
        dt: float,
        mount: CameraMount | None = None,
        frames: int = 8,
        effector: int = 0,
    ) -> "MotionLaw":
        """Makes the law of a robot whose home pose is its start.

        Args:
            config: Bounds of the motion, and the saved poses.
            robot: The robot, which computes the kinematics.
            q0: Configuration to start from, shape (n_q,).
            dt: Time between two steps of the target [s].
            mount: Mount of the wrist camera, which must move with an end
                effector; None without a camera.
            frames: Number of frames of a scan.
            effector: Index of the end effector that is teleoperated. It can
                scan only if it carries the camera.
        """
        X_WE = robot.end_effector_pose(q0, effector)
        X_EC = None
        if mount is not None and robot.effector_that_moves(mount.body) in (
            None,
            effector,
        ):
            X_EC = np.linalg.inv(X_WE) @ mount.pose(q0)
        return MotionLaw(config, X_WE, dt, X_EC, frames, effector)

    def target(self, state: TargetState) -> Target:
        """Returns the target of the end effector.

        Args:
            state: The teleoperated target.
        """
        target = Target.of(state.X_WT)
        if state.mode in (HOLD, SCAN):
            return target
        return target.without(*self.config.free)
