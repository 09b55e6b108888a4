"""`BaseCorrection`: where the frame of the base's odometry lies in the map."""

import dataclasses as dc
from typing import ClassVar

import numpy as np


@dc.dataclass(frozen=True, eq=False)
class BaseCorrection:
    """The pose X_WO of the odometry's frame O in the map's frame W.

    A base measures its pose X_OB by its wheels, and drifts. A map knows where
    the base really was when frames were taken; the two tell X_WO, with which
    X_WB = X_WO X_OB. It is a localisation: whoever uses it takes small steps
    towards it. Copying returns the object itself.

    Attributes:
        pose: x, y, yaw of X_WO, shape (3,) [m, rad].
        covariance: Covariance of the base's x, y, yaw in W when the newest
            frame was taken, shape (3, 3) [m^2, m rad, rad^2].
        time: When that frame was taken, by the diagram's clock [s]; -inf where
            nothing has been corrected.
        rate: How fast x, y and yaw of the base in W leave what this correction
            tells, because the odometry drifts, shape (3,) [m/s, rad/s].
        version: Number of the map that it belongs to.
    """

    MEMORY: ClassVar[float] = 60.0
    """Time over which such rates stay about the same [s]."""

    pose: np.ndarray = dc.field(default_factory=lambda: np.zeros(3))
    covariance: np.ndarray = dc.field(default_factory=lambda: np.zeros((3, 3)))
    time: float = -np.inf
    rate: np.ndarray = dc.field(default_factory=lambda: np.zeros(3))
    version: int = 0

    def __deepcopy__(self, memo) -> "BaseCorrection":
        return self

    def corrected(self, q: np.ndarray) -> np.ndarray:
        """Returns a configuration in W.

        Args:
            q: Configuration whose first three entries are the base's x, y, yaw
                in O, shape (n_q,) or (n, n_q).
        """
        q = np.array(q, float)
        x, y, yaw = self.pose
        c, s = np.cos(yaw), np.sin(yaw)
        q[..., :2] = q[..., :2] @ np.array([[c, s], [-s, c]]) + [x, y]
        q[..., 2] += yaw
        return q

    def base_at(self, time: float, X_OB: np.ndarray) -> np.ndarray:
        """Returns where the base is, as the odometry has drifted since.

        Args:
            time: The time now [s].
            X_OB: The base's pose by odometry now, shape (3,) [m, rad].

        Returns:
            x, y, yaw of X_WB, shape (3,) [m, rad].
        """
        waited = max(0.0, time - self.time) if np.isfinite(self.time) else 0.0
        reach = self.MEMORY * -np.expm1(-waited / self.MEMORY)
        return self.corrected(X_OB) + reach * self.rate
