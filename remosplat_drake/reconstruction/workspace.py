"""`Workspace`: the box in which the robot uses a splat's distances."""

import dataclasses as dc

import numpy as np

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.capture.capture import Capture


@dc.dataclass(frozen=True)
class Workspace:
    """A box in W in which the robot moves, and in which distances are compared.

    Attributes:
        lower: Lower corner, shape (3,) [m].
        upper: Upper corner, shape (3,) [m].
    """

    lower: np.ndarray
    upper: np.ndarray

    @staticmethod
    def around(focus: np.ndarray, reach: float = 1.0) -> "Workspace":
        """Makes a cube around a point, such as the robot's target.

        Args:
            focus: Centre of the cube, shape (3,) [m]. If it is above the floor
                (z = 0), the box is only the cube's part above the floor.
            reach: Half the cube's side length [m].
        """
        focus = np.asarray(focus, float)
        lower = focus - reach
        if focus[2] > 0:
            lower[2] = max(lower[2], 0)
        return Workspace(lower, focus + reach)

    @staticmethod
    def of_capture(capture: Capture, beyond: float = 2.0) -> "Workspace":
        """Makes a box around most of the surfaces that a capture shows.

        Args:
            capture: Posed RGB-D images.
            beyond: Percentage of the measured points that are beyond each side
                of the box.

        Raises:
            RemoSplatError: The capture has no depth.
        """
        p_W = _some_points(capture)
        if not len(p_W):
            raise RemoSplatError("the capture has no depth to compare with")
        return Workspace(*np.percentile(p_W, [beyond, 100 - beyond], axis=0))

    def is_seen(self, capture: Capture) -> bool:
        """Returns whether a capture shows any surface in the box."""
        p_W = _some_points(capture)
        inside = (p_W >= self.lower) & (p_W <= self.upper)
        return bool(inside.all(axis=1).any())


def _some_points(capture: Capture) -> np.ndarray:
    """Points of every eighth row and column of the images, (n, 3) [m]."""
    points = [
        capture.points_W(i)[::8, ::8].reshape(-1, 3)
        for i in range(len(capture))
    ]
    p_W = np.concatenate(points)
    return p_W[np.isfinite(p_W).all(axis=1)]
