"""Alignment of one new view to others with fixed poses."""

from typing import NamedTuple

import numpy as np

from remosplat_drake.reconstruction.alignment.perturbation import (
    difference,
    perturbed,
)
from remosplat_drake.reconstruction.alignment.solver import (
    Level,
    State,
    equations,
    residual_spread,
)
from remosplat_drake.reconstruction.alignment.view_stack import ViewStack

LEVELS = (
    Level(0.10, 0.02, 0.75, 3),
    Level(0.04, 0.005, 0.8, 3),
    Level(0.03, 0.0, 0.85, 3),
)
"""Stages of the refinement, from coarse to fine."""

_CORRELATION = 10.0
"""Neighbouring residuals are correlated: this number of residuals has as much
information as one independent residual.
"""


class AlignedView(NamedTuple):
    """A view's pose, estimated from other views' surfaces and a prior pose.

    Attributes:
        X_WC: The pose, shape (4, 4).
        covariance: Covariance of the pose's errors theta_W and t_W, shape (6,
            6).
        residual: Ratio of residuals to the noise, see `residual_spread`.
        count: Number of the view's points that other views also show.
    """

    X_WC: np.ndarray
    covariance: np.ndarray
    residual: float
    count: int


def align_view(
    stack: ViewStack,
    X_WC: np.ndarray,
    view: int,
    others: np.ndarray,
    covariance: np.ndarray,
) -> AlignedView:
    """Aligns one view to others with fixed poses.

    Args:
        stack: All views.
        X_WC: Poses of all views, shape (n, 4, 4); for the new view, the
            expected pose.
        view: Index of the new view.
        others: Indices of the m views that the new view is compared with, shape
            (m,).
        covariance: Covariance of the expected pose, for example that of the
            odometry since the last view, shape (6, 6).
    """
    given, state = X_WC, State(X_WC)
    pairs = np.stack([np.full(len(others), view), others], axis=1)
    rows = slice(6 * view, 6 * view + 6)
    precision = np.linalg.inv(covariance)
    spread, count = 1.0, 0
    for level in LEVELS:
        for _ in range(level.steps):
            spread = residual_spread(stack, state, pairs, level)
            data = equations(stack, state, pairs, level, spread, _CORRELATION)
            count = int(data.count.sum())
            x = difference(state.X_WC, given)[view]
            covariance = np.linalg.inv(data.H[rows, rows] + precision)
            step = np.zeros((len(X_WC), 6))
            step[view] = -covariance @ (data.g[rows] + precision @ x)
            state = State(perturbed(state.X_WC, step))
            if np.abs(step).max() < 1e-5:
                break
    return AlignedView(state.X_WC[view], covariance, spread, count)
