r"""Keyframes whose surfaces and odometry together tell where the base was.

Unknown is the base's pose b = (x, y, yaw) in W at each keyframe; the camera's
pose on the base is known from the arm. Two terms are minimised by Gauss-Newton:
distances of one view's points from the planes of others (`pair_kernel`), and,
for keyframes that follow each other, how far their motion is from that of the
odometry, (b_i^-1 b_j) - (o_i^-1 o_j), in standard deviations of its drift.
"""

import dataclasses as dc

import numpy as np

from remosplat_drake.mapping.localization.planar_pose import (
    matrix,
    relative,
    relative_jacobians,
)
from remosplat_drake.reconstruction.alignment.alignment import COARSE, FINE
from remosplat_drake.reconstruction.alignment.pair_kernel import pair_residuals
from remosplat_drake.reconstruction.alignment.pair_selection import choose_pairs
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

LEVELS = (*COARSE, *FINE)
"""Stages from coarse to fine of frames that are new."""

REFINING = LEVELS[2:]
"""Those of frames that are where they should be, to centimetres."""

_SEARCH = Level(0.03, 0.01, 0.8, 1)
_SEARCH_STEP = 0.04
_SEARCH_STRIDE = 6
"""What counts as a hit in the search for a start, its step [m], and every how
many points are looked at."""

_PARTNERS = 12
"""Views that each view is compared with, about."""

_CORRELATION = 10.0
"""Residuals that say as much as one; see `estimate_correlation`."""

_SMALLEST_SHIFT, _SMALLEST_TURN = 1e-3, 5e-4
"""Least standard deviations of the odometry's motions [m, rad]."""

_SLIPPERY = 0.03
"""Part of the information on one direction that is none on the other."""

_CONVERGED = 1e-5
"""Steps below end a level [m, rad]."""


@dc.dataclass(frozen=True)
class Drift:
    """How fast the odometry of a base may go wrong.

    Attributes:
        shift: Standard deviation of its position, a second [m/s].
        turn: Standard deviation of its heading, a second [rad/s].
    """

    shift: float
    turn: float

    def deviations(self, seconds: float) -> np.ndarray:
        """Returns standard deviations of x, y, yaw after a time, (3,)."""
        shift = self.shift * seconds + _SMALLEST_SHIFT
        return np.array([shift, shift, self.turn * seconds + _SMALLEST_TURN])


@dc.dataclass(frozen=True, eq=False)
class Keyframes:
    """n keyframes in the order in which they were taken.

    Attributes:
        stack: Their images as planes and points.
        X_OB: The base's poses by odometry, shape (n, 3) [m, rad].
        X_BC: The camera's poses on the base, shape (n, 4, 4).
        age: For how long the odometry had been drifting, shape (n,) [s].
        drift: How fast.
    """

    stack: ViewStack
    X_OB: np.ndarray
    X_BC: np.ndarray
    age: np.ndarray
    drift: Drift

    def __len__(self) -> int:
        return len(self.X_OB)

    def camera_poses(self, X_WB: np.ndarray) -> np.ndarray:
        """Returns X_WC, shape (n, 4, 4), for poses of the base, (n, 3)."""
        return matrix(X_WB) @ self.X_BC

    def select(self, indices: np.ndarray) -> "Keyframes":
        """Returns some of the keyframes, in the order of their indices."""
        stack = self.stack
        rows = {
            name: getattr(stack, name)[indices]
            for name in stack._fields
            if name != "step"
        }
        return Keyframes(
            ViewStack(step=stack.step, **rows),
            self.X_OB[indices],
            self.X_BC[indices],
            self.age[indices],
            self.drift,
        )


@dc.dataclass(frozen=True, eq=False)
class Solution:
    """Where the base was, and how well that is known.

    Attributes:
        X_WB: The base's poses, shape (n, 3) [m, rad].
        covariance: Their covariances, shape (n, 3, 3); 0 for those that were
            not free.
        information: What their surfaces alone tell of them, shape (n, 3, 3).
        residual: Median distance of each keyframe's points from the others'
            surfaces, shape (n,) [m]; NaN for those that share none.
    """

    X_WB: np.ndarray
    covariance: np.ndarray
    information: np.ndarray
    residual: np.ndarray


def solve(
    keyframes: Keyframes,
    X_WB: np.ndarray,
    free: np.ndarray,
    levels: tuple[Level, ...] = LEVELS,
) -> Solution:
    """Refines where the base was at some keyframes.

    Args:
        keyframes: The keyframes.
        X_WB: Where the base was, so far, shape (n, 3) [m, rad].
        free: Which keyframes may move, shape (n,), bool.
        levels: Stages from coarse to fine.
    """
    X_WB = X_WB.copy()
    stack, moving = keyframes.stack, np.repeat(free, 3)
    pairs = np.zeros((0, 2), np.int64)
    H = np.zeros((3 * len(free), 3 * len(free)))
    seen = np.zeros_like(H)
    for level in levels:
        state = State(keyframes.camera_poses(X_WB))
        pairs = choose_pairs(
            stack, state.X_WC, 1.0, 0.0, level.gate, level.least_cosine,
            _PARTNERS,
        )  # fmt: skip
        pairs = pairs[free[pairs].any(axis=1)]
        spread = residual_spread(stack, state, pairs, level)
        for _ in range(level.steps):
            H, g = _odometry(keyframes, X_WB)
            seen[:] = 0
            if len(pairs):
                state = State(keyframes.camera_poses(X_WB))
                data = equations(
                    stack, state, pairs, level, spread, _CORRELATION
                )
                P = _planar(state.X_WC, X_WB)
                seen = P.T @ data.H[:-2, :-2] @ P
                H += seen
                g += P.T @ data.g[:-2]
            step = -np.linalg.solve(H[np.ix_(moving, moving)], g[moving])
            X_WB[free] += step.reshape(-1, 3)
            if np.abs(step).max(initial=0) < _CONVERGED:
                break
    covariance = np.zeros_like(H)
    covariance[np.ix_(moving, moving)] = np.linalg.inv(
        H[np.ix_(moving, moving)]
    )
    own = np.arange(len(free))
    covariance, seen = (
        each.reshape(len(free), 3, len(free), 3)[own, :, own]
        for each in (covariance, seen)
    )
    state = State(keyframes.camera_poses(X_WB))
    residual = _residuals(stack, state, pairs)
    return Solution(X_WB, covariance, seen, residual)


def best_start(
    keyframes: Keyframes, X_WB: np.ndarray, reach: float
) -> np.ndarray:
    """Finds from where the last keyframe is best refined.

    Side faces of things farther off than they are wide are taken for others,
    and tables look alike wherever one slides: so of many places around the
    expected one that is taken at which most points lie on others' surfaces.

    Args:
        keyframes: The keyframes.
        X_WB: Where the base was, shape (n, 3) [m, rad].
        reach: Largest distance from the expected place [m].

    Returns:
        Where the base is taken to have been, shape (3,) [m, rad].
    """
    last = len(keyframes) - 1
    pairs = np.array([(other, last) for other in range(last)])
    stack, level = keyframes.stack, _SEARCH
    kept = -(-stack.point.shape[1] // _SEARCH_STRIDE)
    values = np.empty((len(pairs), 2, kept, 2))
    steps = np.arange(-np.ceil(reach / _SEARCH_STEP), reach / _SEARCH_STEP + 1)
    grid = _SEARCH_STEP * np.stack(np.meshgrid(steps, steps), -1).reshape(-1, 2)
    grid = grid[np.argsort(np.hypot(*grid.T), kind="stable")]
    best, most = X_WB[last], -1
    for offset in grid:
        tried = X_WB.copy()
        tried[last, :2] += offset
        pair_residuals(
            stack, State(keyframes.camera_poses(tried)).pose, 1.0, 0.0, pairs,
            level.gate, level.least_cosine, _SEARCH_STRIDE, values,
        )  # fmt: skip
        hits = np.isfinite(values[..., 0]).sum()
        if hits > most:
            best, most = tried[last], hits
    return best


def slides(information: np.ndarray) -> bool:
    """Whether surfaces leave a base free to slide in some direction.

    A floor and one wall hold a base in one direction; what noise seems to say
    of the other one is little.

    Args:
        information: What they tell of x, y and yaw, shape (3, 3).
    """
    turn = information[2, 2]
    shift = information[:2, :2]
    if turn > 0:
        shift = shift - np.outer(information[:2, 2], information[2, :2]) / turn
    least, most = np.linalg.eigvalsh(shift)
    return bool(least <= _SLIPPERY * most)


def misfit(keyframes: Keyframes, X_WB: np.ndarray, view: int) -> float:
    """Returns how far a view's surfaces are from those of others, wide and far.

    Args:
        keyframes: The keyframes.
        X_WB: Where the base was, shape (n, 3) [m, rad].
        view: Index of the view.

    Returns:
        The median distance [m]; NaN where it shares nothing.
    """
    state, level = State(keyframes.camera_poses(X_WB)), COARSE[0]
    pairs = choose_pairs(
        keyframes.stack, state.X_WC, 1.0, 0.0, level.gate, level.least_cosine,
        _PARTNERS,
    )  # fmt: skip
    own = pairs[(pairs == view).any(axis=1)]
    return float(_residuals(keyframes.stack, state, own)[view])


def _odometry(
    keyframes: Keyframes, X_WB: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Matrix and gradient of what the odometry says, for all poses."""
    n, X_OB = len(keyframes), keyframes.X_OB
    H, g = np.zeros((3 * n, 3 * n)), np.zeros(3 * n)
    waited = np.diff(keyframes.age, prepend=keyframes.age[0])
    for j in range(n):
        if j == 0:
            J, rows = np.eye(3), slice(0, 3)
            error = X_WB[0] - X_OB[0]
        else:
            J = np.hstack(relative_jacobians(X_WB[j - 1], X_WB[j]))
            rows = slice(3 * j - 3, 3 * j + 3)
            moved = relative(X_WB[j - 1], X_WB[j])
            error = moved - relative(X_OB[j - 1], X_OB[j])
        error[2] = (error[2] + np.pi) % (2 * np.pi) - np.pi
        weight = keyframes.drift.deviations(waited[j]) ** -2
        H[rows, rows] += J.T * weight @ J
        g[rows] += J.T * weight @ error
    return H, g


def _planar(X_WC: np.ndarray, X_WB: np.ndarray) -> np.ndarray:
    """How cameras move with their bases: (6n, 3n), by theta_W and t_W."""
    n = len(X_WB)
    P = np.zeros((n, 6, n, 3))
    own = np.arange(n)
    x, y = (X_WC[:, :2, 3] - X_WB[:, :2]).T
    P[own, 3, own, 0] = P[own, 4, own, 1] = 1  # t_W follows x and y,
    P[own, 2, own, 2] = 1  # and theta_W the yaw,
    P[own, 3, own, 2], P[own, 4, own, 2] = -y, x  # which swings the camera.
    return P.reshape(6 * n, 3 * n)


def _residuals(stack: ViewStack, state: State, pairs: np.ndarray) -> np.ndarray:
    """Median distance of each view's points from others' surfaces, (n,)."""
    residual = np.full(len(stack.count), np.nan)
    if not len(pairs):
        return residual
    distances = distances_of_pairs(stack, state, pairs)
    for view in np.unique(pairs).tolist():
        own = distances[(pairs == view).any(axis=1)]
        if np.isfinite(own).any():
            residual[view] = np.nanmedian(own)
    return residual
