"""`BaseCorrection`: the base's pose in the map, corrected for drift."""

import dataclasses as dc

import numpy as np

from remosplat_drake.robot.planar_pose import odometry_frame
from remosplat_drake.signals.base_estimate import (
    BaseEstimate,
    Drift,
    predicted,
)


@dc.dataclass(frozen=True, eq=False)
class BaseCorrection:
    """Localisation of a base with drifting odometry in a map.

    A base measures its pose X_OB with its wheels, in the frame O of its
    odometry, which drifts away from the map's frame W. From each camera frame,
    the mapping estimates the base's true pose at that time, and the rate of the
    drift. The estimate jumps at each frame, so a system that uses it must
    approach it in small steps. Copying returns the object itself.

    Attributes:
        estimate: Estimate of the base's pose at the newest frame; None before
            the first correction, while W and O coincide.
        drift: Drift model of the odometry.
        version: Number of the map that the estimate belongs to.
    """

    estimate: BaseEstimate | None = None
    drift: Drift = dc.field(default_factory=lambda: Drift(0.0, 0.0))
    version: int = 0

    def __deepcopy__(self, memo) -> "BaseCorrection":
        return self

    @property
    def pose(self) -> np.ndarray:
        """X_WO at the time of the newest frame, shape (3,) [m, rad]."""
        if self.estimate is None:
            return np.zeros(3)
        return odometry_frame(self.estimate.X_WB, self.estimate.X_OB)

    def base_at(
        self, time: float, X_OB: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Predicts the base's pose from its motion and drift since the frame.

        Args:
            time: The time now [s].
            X_OB: The base's pose by odometry now, shape (3,) [m, rad].

        Returns:
            x, y, yaw of X_WB, shape (3,) [m, rad], and their covariance, shape
            (3, 3), which grows with time and distance since the newest frame.
        """
        if self.estimate is None:
            return np.array(X_OB, float), np.zeros((3, 3))
        # A frame's stamp may be slightly ahead of this clock; such a small
        # difference does not mean another run.
        now = max(time, self.estimate.time)
        after = predicted(self.estimate, X_OB, now, self.drift)
        return after.X_WB, after.covariance[:3, :3]
