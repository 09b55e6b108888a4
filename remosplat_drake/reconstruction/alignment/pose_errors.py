"""`PoseErrors`: samples of the remaining errors of an alignment."""

import dataclasses as dc

import numpy as np

from remosplat_drake.reconstruction.alignment.camera_errors import COUNT


@dc.dataclass(frozen=True, eq=False)
class PoseErrors:
    """Samples of the errors of n camera poses and of the shared camera errors.

    There are k samples. In each of them, a point that a view measured at p_W is
    truly at p_W + theta x (p_W - p_WC) + t, plus its displacements by the
    camera errors, see `camera_errors`.

    Attributes:
        theta_W: Rotation vectors, shape (k, n, 3) [rad].
        t_W: Translations, shape (k, n, 3) [m].
        camera: Errors that all images share, shape (k, `COUNT`).
    """

    theta_W: np.ndarray
    t_W: np.ndarray
    camera: np.ndarray

    @staticmethod
    def of_draws(draws: np.ndarray) -> "PoseErrors":
        """Makes the samples from the result of `Alignment.draws`."""
        motion = draws[:, :-COUNT].reshape(len(draws), -1, 2, 3)
        return PoseErrors(motion[:, :, 0], motion[:, :, 1], draws[:, -COUNT:])

    def of_views(self, keep: np.ndarray) -> "PoseErrors":
        """Returns the errors of the views that a mask selects."""
        return dc.replace(
            self, theta_W=self.theta_W[:, keep], t_W=self.t_W[:, keep]
        )

    def rotated(self, R_FW: np.ndarray) -> "PoseErrors":
        """Returns the errors expressed in a frame F; R_FW has shape (3, 3)."""
        return dc.replace(
            self, theta_W=self.theta_W @ R_FW.T, t_W=self.t_W @ R_FW.T
        )

    @staticmethod
    def none(views: int) -> "PoseErrors":
        """Makes one sample of zero error, for exact poses."""
        nothing = np.zeros((1, views, 3))
        return PoseErrors(nothing, nothing, np.zeros((1, COUNT)))
