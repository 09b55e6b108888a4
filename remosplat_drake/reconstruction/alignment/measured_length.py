"""`Length`: a manually measured distance that determines a capture's scale."""

import dataclasses as dc

import numpy as np

from remosplat_drake.base.errors import FieldError
from remosplat_drake.capture.capture import Capture
from remosplat_drake.reconstruction.alignment.camera_errors import (
    CARRIED,
    displacements_of,
)
from remosplat_drake.reconstruction.alignment.pair_kernel import POSE
from remosplat_drake.reconstruction.alignment.solver import State


@dc.dataclass(frozen=True)
class Length:
    """The measured distance between two points, given as pixels of views.

    Attributes:
        views: Indices of the two views, which may be equal.
        pixels: Column and row of the first point in the first view, and of the
            second point in the second view [pixels].
        length: Distance of the points [m].
        deviation: Standard deviation of the measured distance, including the
            errors of the points' positions [m].
    """

    views: tuple[int, int]
    pixels: tuple[tuple[int, int], tuple[int, int]]
    length: float
    deviation: float = 0.002

    def points_C(self, capture: Capture) -> np.ndarray:
        """Returns both points in the frames of their cameras, (2, 3) [m].

        Raises:
            FieldError: A view or a pixel does not exist, or a pixel has no
                depth.
        """
        points = []
        for view, (column, row) in zip(self.views, self.pixels, strict=True):
            height, width = capture.size
            if not 0 <= view < len(capture):
                problem = f"has no frame {view}; the last is {len(capture) - 1}"
                raise FieldError("capture", "--length", problem)
            if not (0 <= column < width and 0 <= row < height):
                problem = (
                    f"has no pixel {column} {row}; it has {width} x {height}"
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
    capture: Capture,
    state: State,
    H: np.ndarray,
    g: np.ndarray,
):
    """Adds the residual e = |p_B - p_A| - length to the normal equations.

    Args:
        length: The measured length.
        capture: The capture before the refinement.
        state: Poses, and errors of the camera.
        H: Matrix of all unknowns, shape (6n + k, 6n + k).
        g: Gradient, shape (6n + k,).
    """
    # Poses already include the corrected delay and mount.
    errors = state.errors.copy()
    errors[CARRIED] = state.left[CARRIED]
    shared = POSE * len(state.X_WC)
    ends, arms, shifts = [], [], []
    for view, p_C in zip(length.views, length.points_C(capture), strict=True):
        b_C = displacements_of(capture, view, p_C[None])[0]
        R_WC = state.X_WC[view, :3, :3]
        arms.append(R_WC @ (p_C + errors @ b_C))
        shifts.append(b_C @ R_WC.T)
        ends.append(state.X_WC[view, :3, 3] + arms[-1])
    apart = max(float(np.linalg.norm(ends[1] - ends[0])), 1e-9)
    along = (ends[1] - ends[0]) / apart
    J = np.zeros(len(g))
    for sign, view, arm, shift in zip(
        (-1, 1), length.views, arms, shifts, strict=True
    ):
        J[POSE * view : POSE * view + 3] += sign * np.cross(arm, along)
        J[POSE * view + 3 : POSE * view + 6] += sign * along
        J[shared:] += sign * (shift @ along)
    weight = length.deviation**-2
    H += weight * np.outer(J, J)
    g += weight * J * (apart - length.length)
