"""`BaseCorrection`: where the map has the base, whatever its odometry says."""

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
    """What a map knows of a base whose odometry drifts.

    A base measures its pose X_OB by its wheels, in the frame O of its
    odometry, which leaves the map's frame W by and by. A map knows where the
    base really was when frames were taken, and how fast it went astray. It is
    a localisation: whoever uses it takes small steps towards it. Copying
    returns the object itself.

    Attributes:
        estimate: Where the base was at the newest frame; None where nothing
            has been corrected, and W is O.
        drift: How fast the odometry may go wrong.
        version: Number of the map that it belongs to.
    """

    estimate: BaseEstimate | None = None
    drift: Drift = dc.field(default_factory=lambda: Drift(0.0, 0.0))
    version: int = 0

    def __deepcopy__(self, memo) -> "BaseCorrection":
        return self

    @property
    def pose(self) -> np.ndarray:
        """X_WO when the newest frame was taken, shape (3,) [m, rad]."""
        if self.estimate is None:
            return np.zeros(3)
        return odometry_frame(self.estimate.X_WB, self.estimate.X_OB)

    def base_at(
        self, time: float, X_OB: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Tells where the base is, as it has moved and drifted since.

        Args:
            time: The time now [s].
            X_OB: The base's pose by odometry now, shape (3,) [m, rad].

        Returns:
            x, y, yaw of X_WB, shape (3,) [m, rad], and their covariance,
            shape (3, 3), which grows with the time and the way since the
            newest frame.
        """
        if self.estimate is None:
            return np.array(X_OB, float), np.zeros((3, 3))
        # A frame's clock may be ahead by a moment: another run it is not.
        now = max(time, self.estimate.time)
        after = predicted(self.estimate, X_OB, now, self.drift)
        return after.X_WB, after.covariance[:3, :3]
