"""Localises the base at one frame, relative to keyframes with fixed poses.

The frame is compared with all keyframes that may show its points, for any base
pose within the uncertainty. So loops are closed as early as possible. The pose
is the least-squares solution of point-to-plane equations and of the prediction
from odometry and drift.
"""

import dataclasses as dc

import numpy as np

from remosplat_drake.mapping.localization.keyframe_graph import (
    LEVELS,
    REFINING,
    Keyframes,
    surface_equations,
)
from remosplat_drake.reconstruction.alignment.camera_errors import NO_ERRORS
from remosplat_drake.reconstruction.alignment.pair_kernel import pair_residuals
from remosplat_drake.reconstruction.alignment.solver import (
    Level,
    State,
    residual_spread,
)
from remosplat_drake.signals.base_estimate import BaseEstimate

_POINTS = 40
"""This many points of a frame are compared with other views."""

_DEVIATIONS = 3.0
"""In the search for overlapping views, images are extended beyond their edges
by this number of standard deviations of the base's position.
"""

_LEAST_OVERLAP = 0.15
"""A frame is compared with a view if the view shows at least this fraction of
the frame's points.
"""

_NEAR, _OLD = 5, 3
"""A frame is compared with the views that show most of its points, up to the
first number, and with the oldest views, up to the second number.
"""

_CLOSE = 0.012
"""If the predicted position has at most this standard deviation, the refinement
starts from the prediction, without a search for a start [m].
"""

_SEARCH = Level(0.03, 0.01, 0.8, 1)
_SEARCH_STEP = 0.04
_SEARCH_STRIDE = 6
_FARTHEST = 0.25
"""Parameters of the search for a start of the refinement: limits within which a
point matches a surface, step between candidate positions [m], step between
tested points, and radius around the prediction [m].
"""

_UPRIGHT, _LEAST_SIDE = 0.5, 8
"""A surface is upright if the cosine of the angle between its normal and the
vertical is below the first value. The fit of upright surfaces is measured from
at least as many points as the second value.
"""

_WIDE = LEVELS[0]
"""When a frame's fit is computed, points of two frames belong to the same
surface if they are within these limits."""

_SLIPPERY = 0.03
"""The information on one horizontal direction is ignored if it is at most this
fraction of the information on the other one.
"""

_CONVERGED = 1e-5
"""A stage of the refinement ends when its steps are below this [m, rad]."""


@dc.dataclass(frozen=True, eq=False)
class Placed:
    """The estimated pose of the base at one frame, and the frame's fit.

    Attributes:
        estimate: Estimate of the base's pose.
        residual: Median distance of the frame's points from the surfaces of
            keyframes [m]; NaN if they share no surface.
        shared: Fraction of the frame's points that keyframes also show.
    """

    estimate: BaseEstimate
    residual: float
    shared: float


def candidates(
    keyframes: Keyframes,
    X_WB: np.ndarray,
    frame: Keyframes,
    expected: BaseEstimate,
) -> np.ndarray:
    """Selects the keyframes with which a frame is compared.

    Args:
        keyframes: The keyframes.
        X_WB: Poses of the base, shape (n, 3) [m, rad].
        frame: The frame, as a single keyframe.
        expected: The predicted pose of the base at the frame.

    Returns:
        Indices of keyframes, ascending.
    """
    seen = keyframes.stack
    X_WC = keyframes.camera_poses(X_WB)
    X_WF = frame.camera_poses(expected.X_WB[None])[0]
    count = frame.stack.count[0]
    p_F = frame.stack.point[0, : count : max(1, count // _POINTS)]
    if not len(p_F):
        return np.zeros(0, int)
    p_W = p_F @ X_WF[:3, :3].T + X_WF[:3, 3]
    arm = p_W - X_WC[:, None, :3, 3]
    x, y, z = np.moveaxis(arm @ X_WC[:, :3, :3], -1, 0)
    z = np.where(z > 0, z, np.nan)
    fx, fy, cx, cy = seen.camera.T[:, :, None]
    edge = _DEVIATIONS * expected.deviations[:2].max() * fx / z
    column, row = fx * x / z + cx, fy * y / z + cy
    height, width = (seen.step * size for size in seen.plane.shape[1:3])
    inside = (
        (column > -edge) & (column < width + edge)
        & (row > -edge) & (row < height + edge)
    )  # fmt: skip
    overlap = inside.mean(axis=1)
    usable = np.flatnonzero(overlap >= _LEAST_OVERLAP)
    best = usable[np.argsort(-overlap[usable], kind="stable")][:_NEAR]
    oldest = np.setdiff1d(usable, best)[:_OLD]
    return np.union1d(best, oldest)


def place(
    keyframes: Keyframes,
    X_WB: np.ndarray,
    covariance: np.ndarray,
    expected: BaseEstimate,
) -> Placed:
    """Localises the base at the last keyframe.

    Args:
        keyframes: The keyframes, and after them the frame.
        X_WB: Poses of the base, shape (n, 3) [m, rad]; the last row is ignored.
        covariance: Covariances of all poses except the last, shape (n - 1, 3,
            3).
        expected: The predicted pose of the base at the last keyframe.
    """
    last = len(X_WB) - 1
    pairs = np.array([(other, last) for other in range(last)])
    X_WB = X_WB.copy()
    X_WB[last] = expected.X_WB
    vague = expected.deviations[:2].max()
    levels = LEVELS if vague > _CLOSE else REFINING
    if vague > _CLOSE:
        X_WB[last] = best_start(keyframes, X_WB, min(4 * vague, _FARTHEST))
    prior = np.linalg.inv(expected.covariance[:3, :3])
    seen = np.zeros((3, 3))
    for level in levels:
        state = State(keyframes.camera_poses(X_WB))
        spread = residual_spread(keyframes.stack, state, pairs, level)
        for _ in range(level.steps):
            H, g = surface_equations(keyframes, X_WB, pairs, level, spread)
            seen, pull = without_slips(H[-3:, -3:], g[-3:])
            off = X_WB[last] - expected.X_WB
            step = -np.linalg.solve(seen + prior, pull + prior @ off)
            X_WB[last] += step
            if np.abs(step).max() < _CONVERGED:
                break
    residual, shared = fit(keyframes, X_WB, pairs)
    told = [
        surface_equations(keyframes, X_WB, pair[None], levels[-1], 1.0)[0]
        for pair in pairs
    ]
    weight = np.array([H[-3, -3] + H[-2, -2] for H in told])
    weight /= max(weight.sum(), 1e-9)
    theirs = np.einsum("i,ijk->jk", weight, covariance)
    estimate = updated(expected, X_WB[last], seen, theirs)
    return Placed(estimate, residual, shared)


def updated(
    expected: BaseEstimate,
    X_WB: np.ndarray,
    information: np.ndarray,
    theirs: np.ndarray,
) -> BaseEstimate:
    """Returns the estimate after the placement of a frame.

    The errors of keyframes displace all frames that are aligned to them in the
    same way, so these errors do not average out. The covariance of the
    keyframes is therefore added. If the result is larger than the previous
    covariance, the previous one is used.

    Args:
        expected: The previous estimate.
        X_WB: The most likely pose of the base, shape (3,) [m, rad].
        information: Information matrix of this pose from the frame, shape (3,
            3).
        theirs: Covariance of the keyframes to which the frame was aligned,
            shape (3, 3).
    """
    P = expected.covariance
    gain = P[3:, :3] @ np.linalg.inv(P[:3, :3])
    rate = expected.rate + gain @ (X_WB - expected.X_WB)
    told = np.zeros((6, 6))
    told[:3, :3] = information
    after = np.linalg.inv(np.linalg.inv(P) + told)
    after[:3, :3] += theirs
    if np.trace(after[:2, :2]) > np.trace(P[:2, :2]):
        after = P
    return dc.replace(expected, X_WB=X_WB, rate=rate, covariance=after)


def without_slips(
    H: np.ndarray, g: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Removes the information on a direction in which the base can slide.

    A floor and one wall constrain a base in only one horizontal direction. The
    small amount of information on the other direction is due to noise, and is
    removed.

    Args:
        H: Information matrix of x, y and yaw from surfaces, shape (3, 3).
        g: The gradient of the squared residuals, shape (3,).
    """
    turn = H[2, 2]
    if turn <= 0:
        return H, g
    # Coordinates in which yaw is decoupled from x and y.
    T = np.eye(3)
    T[:2, 2] = H[:2, 2] / turn
    shift = H[:2, :2] - np.outer(H[:2, 2], H[2, :2]) / turn
    values, vectors = np.linalg.eigh(shift)
    if values[0] > _SLIPPERY * values[1]:
        return H, g
    keep = np.eye(3)
    keep[:2, :2] = np.outer(vectors[:, 1], vectors[:, 1])
    # H = T diag(shift, turn) T^T; the weak direction is removed from `shift`.
    middle = np.zeros((3, 3))
    middle[:2, :2], middle[2, 2] = shift, turn
    inner = np.linalg.solve(T, g)
    return T @ keep @ middle @ keep @ T.T, T @ keep @ inner


def best_start(
    keyframes: Keyframes, X_WB: np.ndarray, reach: float
) -> np.ndarray:
    """Finds an initial pose for the refinement of the last keyframe's pose.

    From a poor initial pose, the refinement would match upright surfaces with
    those of other objects. So many positions around the prediction are
    compared. The result is the position at which most of the keyframe's points
    are on surfaces of other keyframes.

    Args:
        keyframes: The keyframes.
        X_WB: Poses of the base, shape (n, 3) [m, rad].
        reach: Largest distance of the initial pose from the prediction [m].

    Returns:
        The initial pose of the base, shape (3,) [m, rad].
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
            stack, State(keyframes.camera_poses(tried)).pose, NO_ERRORS, pairs,
            level.gate, level.least_cosine, _SEARCH_STRIDE, values,
        )  # fmt: skip
        hits = np.isfinite(values[..., 0]).sum()
        if hits > most:
            best, most = tried[last], hits
    return best


def fit(
    keyframes: Keyframes, X_WB: np.ndarray, pairs: np.ndarray
) -> tuple[float, float]:
    """Measures the fit of the last keyframe to all other keyframes.

    Args:
        keyframes: The keyframes.
        X_WB: Poses of the base, shape (n, 3) [m, rad].
        pairs: Indices (i, n - 1) of the compared pairs, shape (m, 2).

    Returns:
        Distance and overlap. The distance is the median distance of the last
        keyframe's points from the surfaces of other keyframes [m]; NaN if they
        share no surface. If the median over points on upright surfaces is
        larger, the distance is that median, since only upright surfaces show a
        horizontal shift. The overlap is the fraction of the last keyframe's
        points that other keyframes show.
    """
    stack, level = keyframes.stack, _WIDE
    values = np.empty((len(pairs), 2, stack.point.shape[1], 2))
    pair_residuals(
        stack, State(keyframes.camera_poses(X_WB)).pose, NO_ERRORS, pairs,
        level.gate, level.least_cosine, 1, values,
    )  # fmt: skip
    distance = np.abs(values[..., 0])
    own = np.isfinite(distance[:, 1]).any(axis=0)
    if not own.any():
        return np.nan, 0.0
    residual = float(np.nanmedian(distance))
    R_WC = keyframes.camera_poses(X_WB)[-1, :3, :3]
    upright = own & (np.abs(stack.normal[-1] @ R_WC[2]) < _UPRIGHT)
    if upright.sum() >= _LEAST_SIDE:
        side = float(np.nanmedian(distance[:, 1, upright]))
        residual = max(residual, side)
    return residual, float(own.sum() / max(stack.count[-1], 1))
