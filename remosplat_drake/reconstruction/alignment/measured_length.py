"""`Length`: a distance that a person has measured, which tells the scale."""

import dataclasses as dc

import numpy as np

from remosplat_drake.base.errors import FieldError
from remosplat_drake.capture.capture import Capture
from remosplat_drake.reconstruction.alignment.solver import State


@dc.dataclass(frozen=True)
class Length:
    """The measured distance of two points, each a pixel of a view.

    Attributes:
        views: Indices of the two views, which may be one and the same.
        pixels: Column and row of the point in either view [pixels].
        length: Distance of the points [m].
        deviation: Standard deviation of the measured distance, and of where
            the points are [m].
    """

    views: tuple[int, int]
    pixels: tuple[tuple[int, int], tuple[int, int]]
    length: float
    deviation: float = 0.002

    def points_C(self, capture: Capture) -> np.ndarray:
        """Returns the two points in their cameras' frames, (2, 3) [m].

        Raises:
            FieldError: There is no such view or pixel, or it has no depth.
        """
        points = []
        for view, (column, row) in zip(self.views, self.pixels, strict=True):
            height, width = capture.size
            if not 0 <= view < len(capture):
                problem = f"has no frame {view}; the last is {len(capture) - 1}"
                raise FieldError("capture", "--length", problem)
            if not (0 <= column < width and 0 <= row < height):
                problem = (
                    f"has no pixel {column} {row}, being {width} x {height}"
                )
                raise FieldError("capture", "--length", problem)
            window = capture.depth[view][
                max(0, row - 1) : row + 2, max(0, column - 1) : column + 2
            ]
            if not (window > 0).any():
                problem = f"has no depth at {column} {row} of frame {view}"
                raise FieldError("capture", "--length", problem)
            z = float(np.median(window[window > 0]))
            K = capture.K[view]
            x = (column + 0.5 - K[0, 2]) / K[0, 0]
            y = (row + 0.5 - K[1, 2]) / K[1, 1]
            points.append([x * z, y * z, z])
        return np.array(points)


def add_length(
    length: Length,
    p_C: np.ndarray,
    state: State,
    H: np.ndarray,
    g: np.ndarray,
):
    """Adds the equation e = |p_B - p_A| - length to those of all unknowns.

    Args:
        length: The length.
        p_C: Its two points, as `Length.points_C` returns them.
        state: Poses, scale and offset.
        H: Matrix of all unknowns, shape (6n + 2, 6n + 2).
        g: Gradient, shape (6n + 2,).
    """
    X = state.X_WC[list(length.views)]
    stretch = state.scale + state.offset / p_C[:, 2]
    raw = np.einsum("vij,vj->vi", X[:, :3, :3], p_C)
    arm = raw * stretch[:, None]
    ends = X[:, :3, 3] + arm
    apart = max(float(np.linalg.norm(ends[1] - ends[0])), 1e-9)
    along = (ends[1] - ends[0]) / apart
    J = np.zeros(len(g))
    for sign, view, r, a, z in zip(
        (-1, 1), length.views, raw, arm, p_C[:, 2], strict=True
    ):
        J[6 * view : 6 * view + 3] += sign * np.cross(a, along)
        J[6 * view + 3 : 6 * view + 6] += sign * along
        J[-2] += sign * (along @ r)
        J[-1] += sign * (along @ r) / z
    weight = length.deviation**-2
    H += weight * np.outer(J, J)
    g += weight * J * (apart - length.length)
