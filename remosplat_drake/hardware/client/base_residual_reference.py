"""Slow, readable reference of `base_residual_kernel.py`."""

import numpy as np


def path_motions(
    rows: np.ndarray, held: float, start: np.ndarray, end: np.ndarray
) -> np.ndarray:
    """Returns motions along a path of arcs, between given times, (..., 3).

    Args:
        rows: Time, x, y, yaw, speeds forward and to the left and turning rate
            at each arc's beginning, shape (k, 7 or more).
        held: A speed is assumed to last for at most this time [s].
        start: Times at which the motions begin, shape (...) [s].
        end: Times at which they end, shape (...) [s].
    """
    time = np.stack([start, end])
    i = np.searchsorted(rows[:, 0], time, "right") - 1
    before = rows[np.maximum(i, 0)]
    late = np.clip(time - before[..., 0], 0.0, held)
    return _relative(*_extrapolated(before[..., 1:4], before[..., 4:7], late))


def path_residuals(
    rows: np.ndarray,
    held: float,
    start: np.ndarray,
    end: np.ndarray,
    moved: np.ndarray,
    late: np.ndarray,
    slack: np.ndarray,
    share: float,
) -> tuple[np.ndarray, np.ndarray]:
    """Compares n motions with delayed motions along a path.

    Args:
        rows: The path, with the columns that `path_motions` describes.
        held: A speed is assumed to last for at most this time [s].
        start: Times at which the motions began, shape (n,) [s].
        end: Times at which they ended, shape (n,) [s].
        moved: The motions, relative to their starts, shape (n, 3) [m, m, rad].
        late: Delays that are tried, ascending, shape (k,) [s].
        slack: Permitted difference of a motion, shape (2,) [m, rad].
        share: Further permitted difference, as a fraction of the distance
            driven.

    Returns:
        For each motion, the best-fitting motion along the path, shape (n, 3),
        and the ratio of their difference to the permitted difference, shape
        (n,).
    """
    told = path_motions(rows, held, start[:, None] - late, end[:, None] - late)
    error = _size(_relative(told, moved[:, None]))
    spread = 0.5 * _size(_relative(told[:, :-1], told[:, 1:])).max(axis=1)
    way = np.maximum(_size(told).max(axis=1), _size(moved))
    allowed = slack + share * way + spread
    # An error of the heading rotates the motion.
    allowed[:, 0] += 0.5 * allowed[:, 1] * way[:, 0]
    excess = (error / allowed[:, None]).max(axis=2)
    best = excess.argmin(axis=1)
    each = np.arange(len(best))
    return told[each, best], excess[each, best]


def _extrapolated(
    pose: np.ndarray, u: np.ndarray, duration: np.ndarray
) -> np.ndarray:
    """`extrapolated_pose` for many poses, shape (..., 3)."""
    half = 0.5 * u[..., 2] * duration
    share = duration * np.sinc(half / np.pi)
    forward, left = share * u[..., 0], share * u[..., 1]
    c, s = np.cos(pose[..., 2] + half), np.sin(pose[..., 2] + half)
    return pose + np.stack(
        [forward * c - left * s, forward * s + left * c, 2 * half], axis=-1
    )


def _relative(X_AB: np.ndarray, X_AC: np.ndarray) -> np.ndarray:
    """`planar_pose.relative` for many poses, shape (..., 3)."""
    x, y, yaw = np.moveaxis(X_AC - X_AB, -1, 0)
    c, s = np.cos(X_AB[..., 2]), np.sin(X_AB[..., 2])
    yaw = (yaw + np.pi) % (2 * np.pi) - np.pi
    return np.stack([c * x + s * y, c * y - s * x, yaw], axis=-1)


def _size(motion: np.ndarray) -> np.ndarray:
    """Lengths and angles of motions, shape (..., 2) [m, rad]."""
    length = np.hypot(motion[..., 0], motion[..., 1])
    return np.stack([length, np.abs(motion[..., 2])], axis=-1)
