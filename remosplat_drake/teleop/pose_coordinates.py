"""`PoseCoordinates`: six numbers of a pose that sliders can set."""

import numpy as np
from pydrake.math import RollPitchYaw, RotationMatrix


class PoseCoordinates:
    """A position in W, and roll, pitch and yaw relative to a reference.

    Angles are relative to the reference H, so that they are zero at the robot's
    start. They are then far from the values at which they wrap around: R_WT =
    R(roll, pitch, yaw) R_WH about W's axes.

    Args:
        X_WH: Pose of the reference H, shape (4, 4).
    """

    def __init__(self, X_WH: np.ndarray):
        self._R_WH = RotationMatrix.ProjectToRotationMatrix(X_WH[:3, :3])

    def of(self, X_WT: np.ndarray) -> np.ndarray:
        """Returns the six numbers of a pose.

        Args:
            X_WT: The pose, shape (4, 4).

        Returns:
            Position [m] and roll, pitch, yaw [deg], shape (6,).
        """
        R_WT = RotationMatrix.ProjectToRotationMatrix(X_WT[:3, :3])
        angles = RollPitchYaw(R_WT @ self._R_WH.inverse()).vector()
        return np.concatenate([X_WT[:3, 3], np.degrees(angles)])

    def pose(self, values: np.ndarray) -> np.ndarray:
        """Returns the pose of six numbers, shape (4, 4).

        Args:
            values: Position [m] and roll, pitch, yaw [deg], shape (6,).
        """
        X_WT = np.eye(4)
        X_WT[:3, 3] = values[:3]
        turn = RollPitchYaw(np.radians(values[3:])).ToRotationMatrix()
        X_WT[:3, :3] = (turn @ self._R_WH).matrix()
        return X_WT
