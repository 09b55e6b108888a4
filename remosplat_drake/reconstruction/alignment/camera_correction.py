"""`corrected`: corrects the errors that all images of a capture share."""

import dataclasses as dc

import numpy as np
from scipy.spatial.transform import Rotation

from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.undistortion import Distortion, distort
from remosplat_drake.reconstruction.alignment.camera_errors import (
    ASPECT,
    CENTER_X,
    CENTER_Y,
    DELAY,
    FOCAL,
    GROWTH,
    K1,
    K2,
    OFFSET,
    READOUT,
    SCALE,
    SHIFT,
    TURN,
    velocity_C,
)
from remosplat_drake.reconstruction.alignment.perturbation import perturbed

_ROUNDS = 4
"""Number of fixed-point iterations that find the position of a new pixel in the
measured image. They are necessary because the motion of a row depends on the
depth at that position."""

_JUMP = 0.05
"""Neighbouring pixels belong to different surfaces if the relative difference
of their inverse depths exceeds this value.
"""

_APART = 1.5
"""The depth of a new pixel is unknown, because its point is occluded, if the
pixel that the iterations find is farther than this from the position that its
depth implies [pixels]."""


def corrected(capture: Capture, errors: np.ndarray) -> Capture:
    """Corrects the errors that all images of a capture share.

    The result has corrected focal lengths and principal points. Its poses are
    corrected for the images' delay and for the camera's pose on its carrier,
    and its depths for scale, offset and growth. To correct distortion and
    read-out time, new images are resampled from the measured ones.

    Args:
        capture: Posed RGB-D images.
        errors: The errors, see `camera_errors`, shape (`COUNT`,).
    """
    K = capture.K.astype(float)
    focal_x = K[:, 0, 0].copy()
    K[:, 0, 0] *= 1 + errors[FOCAL]
    K[:, 1, 1] *= 1 + errors[FOCAL] + errors[ASPECT]
    K[:, 0, 2] += errors[CENTER_X] * focal_x
    K[:, 1, 2] += errors[CENTER_Y] * capture.K[:, 1, 1]
    moved = dc.replace(_carried(capture, errors), K=K)
    if errors[[K1, K2, READOUT]].any():
        moved = _resampled(moved, errors)
    depth = 1 + errors[SCALE], errors[OFFSET], errors[GROWTH]
    return moved.with_depth(*depth)


def _carried(capture: Capture, errors: np.ndarray) -> Capture:
    """Returns the capture with corrected delay and mount."""
    delay = errors[DELAY]
    moved, X_WC = capture, capture.X_WC.copy()
    if capture.velocity_W is not None:
        motion = delay * capture.velocity_W
        if capture.acceleration_W is not None:
            motion = motion + delay**2 / 2 * capture.acceleration_W
            velocity_W = capture.velocity_W + delay * capture.acceleration_W
            moved = dc.replace(capture, velocity_W=velocity_W)
        X_WC = perturbed(X_WC, motion)
    X_CD = np.eye(4)
    turn = Rotation.from_rotvec(errors[TURN : TURN + 3])
    X_CD[:3, :3] = turn.as_matrix()
    X_CD[:3, 3] = errors[SHIFT : SHIFT + 3]
    return dc.replace(moved, X_WC=X_WC @ X_CD)


def delay_of_motion(
    capture: Capture, motion: np.ndarray
) -> tuple[float, float]:
    """Finds the delay between poses and images that best explains pose errors.

    A common rigid motion and scale of all poses is ignored.

    Args:
        capture: Posed RGB-D images.
        motion: Errors theta_W and t_W of each pose, shape (n, 6).

    Returns:
        The delay by least squares [s], and the fraction of the sum of squared
        pose errors that remains after its correction. They are 0 and 1 if
        velocities are unknown.
    """
    count, p_WC = len(capture), capture.X_WC[:, :3, 3]
    if capture.velocity_W is None:
        return 0.0, 1.0
    gauge = np.zeros((count, 6, 7))
    for axis in range(3):
        gauge[:, axis, axis] = gauge[:, 3 + axis, 3 + axis] = 1
        gauge[:, 3:, axis] = np.cross(np.eye(3)[axis], p_WC)
    gauge[:, 3:, 6] = p_WC
    basis = np.linalg.qr(gauge.reshape(-1, 7))[0]
    both = np.stack([motion.ravel(), capture.velocity_W.ravel()], axis=1)
    error, velocity = (both - basis @ (basis.T @ both)).T
    delay = (error @ velocity) / max(velocity @ velocity, 1e-30)
    rest = np.square(error - delay * velocity).sum()
    return float(delay), float(rest / max(error @ error, 1e-30))


def _resampled(capture: Capture, errors: np.ndarray) -> Capture:
    """Resamples images, as pinhole cameras with a global shutter."""
    hidden = np.zeros(capture.depth.shape, bool)
    if capture.hidden is not None:
        hidden = capture.hidden.copy()
    rgb, depth = np.empty_like(capture.rgb), np.empty_like(capture.depth)
    for view in range(len(capture)):
        image = (
            capture.K[view],
            capture.depth[view],
            velocity_C(capture, view),
            errors,
        )
        found = _sources(*image)
        row, column, z, lost = _with_nearer(*image, found)
        rgb[view] = capture.rgb[view, row, column]
        depth[view] = z
        hidden[view] = hidden[view, row, column] | lost
    return dc.replace(capture, rgb=rgb, depth=depth, hidden=hidden)


def _sources(
    K: np.ndarray, depth: np.ndarray, velocity: np.ndarray, errors: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Finds the positions of a new image's pixels in the measured image.

    Args:
        K: Intrinsic matrix, shape (3, 3) [pixels].
        depth: Depth of the measured image, shape (h, w) [m].
        velocity: Velocity of the camera in C, shape (6,).
        errors: The errors.

    Returns:
        Four arrays of shape (h, w): rows and columns in the measured image, the
        new depth, and a mask of the pixels that the measured image does not
        show.
    """
    height, width = depth.shape
    lens = Distortion(k1=errors[K1], k2=errors[K2])
    focal, center = K[[0, 1], [0, 1]], K[:2, 2]
    u, v = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    xy = (np.stack([u, v], axis=-1) - center) / focal
    ray = np.concatenate([xy, np.ones((height, width, 1))], axis=-1)

    def place(z: np.ndarray, row: np.ndarray):
        """Returns the measured pixels and the motion of points."""
        # A point is fixed in W, so in C it moves opposite to the camera.
        p = z[..., None] * ray
        motion = _row_motion(p, row, height, velocity, errors)
        old = p - motion
        there = distort(lens, old[..., :2] / old[..., 2:]) * focal + center
        return there, motion[..., 2]

    row = np.indices(depth.shape)[0]
    z = _filled(depth)
    there, column, found = np.zeros((height, width, 2)), row, depth
    for _ in range(_ROUNDS):
        there, moved = place(z, row)
        column, row = _inside(depth, there)
        found = _looked_up(depth, there)
        z = np.where(found > 0, found + moved, z)
    aside = np.abs(place(z, row)[0] - there).max(axis=-1)
    outside = np.any((there < 0) | (there >= [width, height]), axis=-1)
    unknown = outside | (aside > _APART) | (found <= 0)
    return row, column, np.where(unknown, 0, z), outside


def _row_motion(
    p_C: np.ndarray,
    row: np.ndarray,
    height: int,
    velocity: np.ndarray,
    errors: np.ndarray,
) -> np.ndarray:
    """Motion of points from their row's read-out to the middle row's [m]."""
    time = errors[READOUT] * ((row + 0.5) / height - 0.5)[..., None]
    return time * (velocity[3:] + np.cross(velocity[:3], p_C))


def _with_nearer(
    K: np.ndarray,
    depth: np.ndarray,
    velocity: np.ndarray,
    errors: np.ndarray,
    found: tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray],
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Adds nearer points to the result of `_sources`.

    If a cable is in front of a wall, both may match a pixel, and the nearer one
    is visible. So each measured pixel is also moved to its corrected position,
    and no thin object is lost.

    Args:
        K: Intrinsic matrix, shape (3, 3) [pixels].
        depth: Depth of the measured image, shape (h, w) [m].
        velocity: Velocity of the camera in C, shape (6,).
        errors: The errors.
        found: The result of `_sources`.
    """
    row, column, z, lost = found
    row, column, z = row.copy(), column.copy(), z.copy()
    height, width = depth.shape
    old_row, old_column = np.nonzero(depth > 0)
    focal, center = K[[0, 1], [0, 1]], K[:2, 2]
    seen = (np.stack([old_column, old_row], axis=-1) + 0.5 - center) / focal
    xy, lens = seen.copy(), Distortion(k1=errors[K1], k2=errors[K2])
    for _ in range(_ROUNDS):
        xy += seen - distort(lens, xy)
    p = (
        np.column_stack([xy, np.ones(len(xy))])
        * depth[old_row, old_column, None]
    )
    p += _row_motion(p, old_row, height, velocity, errors)
    u, v = np.floor(p[:, :2] / p[:, 2:] * focal + center).astype(int).T
    inside = (u >= 0) & (u < width) & (v >= 0) & (v < height) & (p[:, 2] > 0)
    order = np.flatnonzero(inside)
    order = order[np.argsort(-p[order, 2], kind="stable")]
    # The nearest is written last.
    landed = np.full(depth.shape, -1)
    landed[v[order], u[order]] = order
    nearer = landed >= 0
    new = np.where(nearer, p[landed, 2], np.inf)
    doubted = (z <= 0) & (depth[row, column] > 0)
    nearer &= ~lost & (doubted | (new < (1 - _JUMP) * z))
    row[nearer], column[nearer] = (
        old_row[landed[nearer]],
        old_column[landed[nearer]],
    )
    z[nearer] = new[nearer]
    return row, column, z, lost


def _inside(
    depth: np.ndarray, there: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Column and row of the pixel that is nearest to each position, (h, w)."""
    height, width = depth.shape
    column, row = np.floor(there).astype(int).transpose(2, 0, 1)
    return column.clip(0, width - 1), row.clip(0, height - 1)


def _looked_up(depth: np.ndarray, there: np.ndarray) -> np.ndarray:
    """Depths at positions in an image, (h, w) [m]; 0 where unknown.

    On a plane, 1/z is linear in the image, so it is interpolated between four
    pixels of one surface. At an edge the nearest pixel is used, because an
    interpolated depth would belong to neither surface.
    """
    height, width = depth.shape
    column, row = _inside(depth, there)
    picked = depth[row, column]
    left, top = np.floor(there - 0.5).astype(int).transpose(2, 0, 1)
    right_part, lower_part = (
        there - 0.5 - np.stack([left, top], -1)
    ).transpose(2, 0, 1)
    inverse = 1 / np.where(depth > 0, depth, np.nan)
    corners, weights = [], []
    for i in (0, 1):
        for j in (0, 1):
            r, c = (top + i).clip(0, height - 1), (left + j).clip(0, width - 1)
            corners.append(inverse[r, c])
            down = lower_part if i else 1 - lower_part
            weights.append(down * (right_part if j else 1 - right_part))
    corners, weights = np.array(corners), np.array(weights)
    with np.errstate(invalid="ignore", divide="ignore"):
        smooth = np.ptp(corners, axis=0) < _JUMP * corners.mean(axis=0)
        between = 1 / (weights * corners).sum(axis=0)
    return np.where(smooth, between, picked)


def _filled(depth: np.ndarray) -> np.ndarray:
    """Depths [m], with unknown ones replaced by the median."""
    known = depth > 0
    usual = float(np.median(depth[known])) if known.any() else 1.0
    return np.where(known, depth, usual).astype(float)
