r"""Keyframe graph: estimates base poses from shared surfaces and motions.

The unknowns are the base's poses b = (x, y, yaw) in W at all keyframes. The
camera's pose on the base is known from the arm's joints. Gauss-Newton minimises
the sum of two kinds of squared residuals. The first kind are the distances of
one view's points from the planes of other views (`pair_kernel`). The second
kind are, for consecutive keyframes i and j, the differences (b_i^-1 b_j) -
(t_i^-1 t_j) between their motion and the motion of the tracked poses t. They
are divided by the standard deviations of the tracked motion.
"""

import dataclasses as dc
from collections.abc import Sequence

import numpy as np

from remosplat_drake.reconstruction.alignment.pair_selection import choose_pairs
from remosplat_drake.reconstruction.alignment.refinement import COARSE, FINE
from remosplat_drake.reconstruction.alignment.residual_table import (
    distances_of_pairs,
)
from remosplat_drake.reconstruction.alignment.solver import (
    Level,
    State,
    equations,
    residual_spread,
)
from remosplat_drake.reconstruction.alignment.view_stack import ViewStack
from remosplat_drake.robot.planar_pose import (
    matrix,
    relative,
    relative_jacobians,
)

LEVELS = (*COARSE, *FINE)
"""Stages of the refinement, from coarse to fine, for new frames."""

REFINING = LEVELS[3:]
"""Stages of the refinement for frames with errors below a centimetre."""

_PARTNERS = 12
"""Each view is compared with approximately this many other views."""

_CORRELATION = 10.0
"""This many residuals have as much information as one independent residual,
since neighbouring residuals are correlated; see `estimate_correlation`.
"""

_LEAST_DOUBT = np.diag([1e-3, 1e-3, 5e-4]) ** 2
"""Covariance that is added to that of each tracked motion [m^2, rad^2]."""

_CONVERGED = 1e-5
"""A stage of the refinement ends when its steps are below this [m, rad]."""


@dc.dataclass(frozen=True, eq=False)
class Keyframes:
    """Keyframes in the order in which they were taken; there are n.

    Attributes:
        stack: Images of the keyframes, as planes and points.
        X_BC: The camera's poses on the base, shape (n, 4, 4).
        X_OB: The base's poses by odometry, shape (n, 3) [m, rad].
        time: Times of the images, shape (n,) [s].
    """

    stack: ViewStack
    X_BC: np.ndarray
    X_OB: np.ndarray
    time: np.ndarray

    def __len__(self) -> int:
        return len(self.X_OB)

    def camera_poses(self, X_WB: np.ndarray) -> np.ndarray:
        """Returns X_WC, shape (n, 4, 4), for poses of the base, (n, 3)."""
        return matrix(X_WB) @ self.X_BC

    def select(self, indices: np.ndarray) -> "Keyframes":
        """Returns the keyframes of the given indices, in this order."""
        stack = self.stack
        rows = {
            name: getattr(stack, name)[indices]
            for name in ViewStack._fields
            if name != "step"
        }
        return Keyframes(
            ViewStack(step=stack.step, **rows),
            self.X_BC[indices],
            self.X_OB[indices],
            self.time[indices],
        )

    @staticmethod
    def joined(parts: "Sequence[Keyframes]") -> "Keyframes":
        """Concatenates several parts, in their order."""
        stacks = [part.stack for part in parts]
        rows = {
            name: np.concatenate([getattr(stack, name) for stack in stacks])
            for name in ViewStack._fields
            if name != "step"
        }
        return Keyframes(
            ViewStack(step=stacks[0].step, **rows),
            *(
                np.concatenate([getattr(part, name) for part in parts])
                for name in ("X_BC", "X_OB", "time")
            ),
        )


@dc.dataclass(frozen=True, eq=False)
class Solution:
    """Poses of the base, with their covariances.

    Attributes:
        X_WB: The base's poses, shape (n, 3) [m, rad].
        covariance: Covariances of the poses, shape (n, 3, 3); 0 for the first
            pose.
        residual: Median distance of each keyframe's points from the surfaces of
            other keyframes, shape (n,) [m]; NaN for a keyframe that shares no
            surface.
    """

    X_WB: np.ndarray
    covariance: np.ndarray
    residual: np.ndarray


def solve(
    keyframes: Keyframes,
    X_WB: np.ndarray,
    tracked: np.ndarray,
    covariance: np.ndarray,
    levels: tuple[Level, ...] = REFINING,
) -> Solution:
    """Refines the base's poses at all keyframes; the first one defines W.

    Args:
        keyframes: The keyframes.
        X_WB: Initial poses of the base, shape (n, 3) [m, rad].
        tracked: Tracked poses of the base, shape (n, 3) [m, rad].
        covariance: Covariances of the tracked poses, shape (n, 3, 3).
        levels: Stages from coarse to fine.
    """
    n, stack = len(X_WB), keyframes.stack
    X_WB, inverse = X_WB.copy(), np.zeros((3 * n, 3 * n))
    pairs = np.zeros((0, 2), np.int64)
    for level in levels:
        at = State(keyframes.camera_poses(X_WB))
        pairs = choose_pairs(
            stack, at.X_WC, at.left, level.gate, level.least_cosine, _PARTNERS
        )
        spread = residual_spread(stack, at, pairs, level)
        for _ in range(level.steps):
            H, g = motion_equations(X_WB, tracked, covariance)
            if len(pairs):
                seen, pull = surface_equations(
                    keyframes, X_WB, pairs, level, spread
                )
                H, g = H + seen, g + pull
            inverse[3:, 3:] = np.linalg.inv(H[3:, 3:])
            step = -inverse @ g
            X_WB += step.reshape(n, 3)
            if np.abs(step).max() < _CONVERGED:
                break
    own = np.arange(n)
    return Solution(
        X_WB,
        inverse.reshape(n, 3, n, 3)[own, :, own],
        residuals(keyframes, X_WB, pairs),
    )


def surface_equations(
    keyframes: Keyframes,
    X_WB: np.ndarray,
    pairs: np.ndarray,
    level: Level,
    spread: float,
) -> tuple[np.ndarray, np.ndarray]:
    """Returns Hessian (3n, 3n) and gradient (3n,) of the surface residuals.

    Args:
        keyframes: The keyframes.
        X_WB: Poses of the base, shape (n, 3) [m, rad].
        pairs: Indices of the keyframes that are compared, shape (m, 2).
        level: The stage of the refinement, whose limits the residuals must
            meet.
        spread: The result of `residual_spread`.
    """
    state = State(keyframes.camera_poses(X_WB))
    data = equations(keyframes.stack, state, pairs, level, spread, _CORRELATION)
    P = _planar(state.X_WC, X_WB)
    return P.T @ data.H @ P, P.T @ data.g


def motion_equations(
    X_WB: np.ndarray, tracked: np.ndarray, covariance: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Returns Hessian (3n, 3n) and gradient (3n,) of the motion residuals.

    Args:
        X_WB: Poses of the base, shape (n, 3) [m, rad].
        tracked: Tracked poses of the base, shape (n, 3) [m, rad].
        covariance: Covariances of the tracked poses, shape (n, 3, 3).
    """
    n = len(X_WB)
    H, g = np.zeros((3 * n, 3 * n)), np.zeros(3 * n)
    for i in range(n - 1):
        error = relative(X_WB[i], X_WB[i + 1])
        error -= relative(tracked[i], tracked[i + 1])
        error[2] = (error[2] + np.pi) % (2 * np.pi) - np.pi
        R_WB = matrix(tracked[i])[:3, :3]
        doubt = R_WB.T @ (covariance[i] + covariance[i + 1]) @ R_WB
        weight = np.linalg.inv(doubt + _LEAST_DOUBT)
        J = np.hstack(relative_jacobians(X_WB[i], X_WB[i + 1]))
        rows = slice(3 * i, 3 * i + 6)
        H[rows, rows] += J.T @ weight @ J
        g[rows] += J.T @ weight @ error
    return H, g


def residuals(
    keyframes: Keyframes, X_WB: np.ndarray, pairs: np.ndarray
) -> np.ndarray:
    """Returns the median distance of each view from other views' surfaces.

    Args:
        keyframes: The keyframes.
        X_WB: Poses of the base, shape (n, 3) [m, rad].
        pairs: Indices of the keyframes that are compared, shape (m, 2).

    Returns:
        The median distances, shape (n,) [m]; NaN for views that share no
        surface.
    """
    residual = np.full(len(X_WB), np.nan)
    if not len(pairs):
        return residual
    state = State(keyframes.camera_poses(X_WB))
    distances = distances_of_pairs(keyframes.stack, state, pairs)
    for view in np.unique(pairs).tolist():
        own = distances[(pairs == view).any(axis=1)]
        if np.isfinite(own).any():
            residual[view] = np.nanmedian(own)
    return residual


def _planar(X_WC: np.ndarray, X_WB: np.ndarray) -> np.ndarray:
    """Returns the Jacobian of camera errors by base poses, (6n, 3n)."""
    n = len(X_WB)
    P = np.zeros((n, 6, n, 3))
    own = np.arange(n)
    x, y = (X_WC[:, :2, 3] - X_WB[:, :2]).T
    P[own, 3, own, 0] = P[own, 4, own, 1] = 1  # t_W follows x and y,
    P[own, 2, own, 2] = 1  # and theta_W the yaw,
    P[own, 3, own, 2], P[own, 4, own, 2] = -y, x  # which swings the camera.
    return P.reshape(6 * n, 3 * n)
