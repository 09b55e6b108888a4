"""`BaseCorrection`: the pose of the base in the map, corrected for drift."""

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
    """The pose in a map of a base whose odometry drifts.

    The wheels of a base measure its pose X_OB in the frame O of the odometry. O
    drifts away from the map's frame W. For each camera image, the mapping
    estimates the base's true pose at the time of the image, and the rate of the
    drift. The estimate jumps with each image, so a system that uses it must
    approach it in small steps. Copying returns the object itself.

    Attributes:
        estimate: Estimate of the base's pose at the time of the newest camera
            image. It is None before the first correction; until then, W and O
            coincide.
        drift: Drift model of the odometry.
        version: Version of the map to which the estimate belongs.
    """

    estimate: BaseEstimate | None = None
    drift: Drift = dc.field(default_factory=lambda: Drift(0.0, 0.0))
    version: int = 0

    def __deepcopy__(self, memo) -> "BaseCorrection":
        return self

    @property
    def pose(self) -> np.ndarray:
        """X_WO at the time of the newest image, shape (3,) [m, rad]."""
        if self.estimate is None:
            return np.zeros(3)
        return odometry_frame(self.estimate.X_WB, self.estimate.X_OB)

    def base_at(
        self, time: float, X_OB: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Predicts the present pose from motion and drift since the image.

        Args:
            time: The present time [s].
            X_OB: The present pose of the base by odometry, shape (3,) [m, rad].

        Returns:
            x, y and yaw of X_WB, shape (3,) [m, rad], and their covariance,
            shape (3, 3). The covariance increases with the time and the
            distance since the newest image.
        """
        if self.estimate is None:
            return np.array(X_OB, float), np.zeros((3, 3))
        # The stamp of an image may be slightly ahead of this clock. Such a
        # small difference does not mean that another run has begun.
        now = max(time, self.estimate.time)
        after = predicted(self.estimate, X_OB, now, self.drift)
        return after.X_WB, after.covariance[:3, :3]
