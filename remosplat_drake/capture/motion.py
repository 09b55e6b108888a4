"""Computes velocities of a camera while its images were taken."""

import numpy as np
from scipy.spatial.transform import Rotation

LONGEST_STEP = 0.2
"""A velocity is computed from the poses of two frames only if the time between
them is at most this [s].
"""

ACCELERATION_SPAN = 0.1
"""A frame's acceleration is computed from the camera's velocities this long
before and after the frame [s].
"""


def camera_velocities(times: np.ndarray, X_WC: np.ndarray) -> np.ndarray:
    """Computes a camera's velocities as central differences of its poses.

    If only one of a frame's neighbours is near enough in time, the velocity is
    the difference to this neighbour.

    Args:
        times: Times of n frames in any order, shape (n,) [s].
        X_WC: Camera poses of the frames, shape (n, 4, 4).

    Returns:
        Angular velocities in W [rad/s], then velocities of the camera's centre
        in W [m/s], shape (n, 6); NaN for a frame without a usable pose, or
        without a neighbour within `LONGEST_STEP`.
    """
    velocity_W = np.full((len(times), 6), np.nan)
    order = np.argsort(times, kind="stable")
    order = order[_usable(times, X_WC)[order]]
    if len(order) < 2:
        return velocity_W
    t, X_WC = times[order], X_WC[order]
    step = np.diff(t)
    joined = (step > 0) & (step < LONGEST_STEP)
    index = np.arange(len(order))
    before = index - np.concatenate([[False], joined])
    after = index + np.concatenate([joined, [False]])
    known = after > before
    before, after = before[known], after[known]
    elapsed = (t[after] - t[before])[:, None]
    R_WA = Rotation.from_matrix(X_WC[after, :3, :3])
    R_WB = Rotation.from_matrix(X_WC[before, :3, :3])
    turned_W = (R_WA * R_WB.inv()).as_rotvec()
    moved_W = X_WC[after, :3, 3] - X_WC[before, :3, 3]
    velocity_W[order[known]] = np.hstack([turned_W, moved_W]) / elapsed
    return velocity_W


def camera_accelerations(
    times: np.ndarray, velocity_W: np.ndarray
) -> np.ndarray:
    """Computes a camera's accelerations.

    An acceleration is computed from the velocities at the times
    `ACCELERATION_SPAN` before and after the frame. In differences between
    neighbouring frames, the jitter of poses would dominate.

    Args:
        times: Times of n frames in any order, shape (n,) [s].
        velocity_W: The result of `camera_velocities`, shape (n, 6).

    Returns:
        Angular accelerations [rad/s^2], then accelerations of the camera's
        centre in W [m/s^2], shape (n, 6); NaN where they are unknown.
    """
    acceleration_W = np.full(velocity_W.shape, np.nan)
    order = np.argsort(times, kind="stable")
    order = order[np.isfinite(velocity_W[order]).all(axis=1)]
    if len(order) < 2:
        return acceleration_W
    t, v = times[order], velocity_W[order]
    piece = np.cumsum(np.diff(t, prepend=t[0]) >= LONGEST_STEP)
    for number in range(piece[-1] + 1):
        own = np.flatnonzero(piece == number)
        start = np.maximum(t[own] - ACCELERATION_SPAN, t[own[0]])
        end = np.minimum(t[own] + ACCELERATION_SPAN, t[own[-1]])
        if not (end > start).all():
            continue
        changed = [
            np.interp(end, t[own], each) - np.interp(start, t[own], each)
            for each in v[own].T
        ]
        rate = np.stack(changed, axis=1) / (end - start)[:, None]
        acceleration_W[order[own]] = rate
    return acceleration_W


def _usable(times: np.ndarray, X_WC: np.ndarray) -> np.ndarray:
    """Mask of the frames with a time and a valid pose, (n,)."""
    with np.errstate(over="ignore", invalid="ignore"):
        turns = np.linalg.det(X_WC[:, :3, :3])
        return np.isfinite(times + turns + X_WC.sum(axis=(1, 2))) & (turns > 0)
