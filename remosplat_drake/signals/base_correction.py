"""`BaseCorrection`: where the frame of the base's odometry lies in the map."""

import dataclasses as dc

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
    """

    pose: np.ndarray = dc.field(default_factory=lambda: np.zeros(3))
    covariance: np.ndarray = dc.field(default_factory=lambda: np.zeros((3, 3)))
    time: float = -np.inf

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
