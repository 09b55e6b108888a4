"""Selects the frames of a map."""

from collections.abc import Callable

import numpy as np

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.checks.overlap import (
    measure_overlap,
    supported_fractions,
    wrong_frames,
)
from remosplat_drake.capture.frames import Frame
from remosplat_drake.mapping.base_splat import shares_of
from remosplat_drake.splat.gaussian_splat import GaussianSplat

SAME_POSITION = 0.01
"""Two frames are from nearly the same pose if the distance between their
cameras is below this value [m], and the angle is below `SAME_ROTATION`.
"""

SAME_ROTATION = np.deg2rad(2.0)
"""Two frames are from nearly the same pose if the angle between their cameras
is below this value [rad], and the distance is below `SAME_POSITION`.
"""

_HIDDEN_SHARE = 0.01
"""A newer frame replaces an older one from the same pose only if it masks at
most this fraction of the pixels with depth of the older frame.
"""

_MIN_SHARE = 0.2
"""A frame is confirmed if other frames show at least this fraction of its
surfaces. For rendered tables, the fraction is at least 0.58 for a frame with a
correct pose, and 0 for a frame with a wrong pose.
"""


def hides_view_of(newer: Frame, older: Frame) -> bool:
    """Returns whether a frame masks surfaces that an older frame shows.

    Args:
        newer: A frame, which may have masked pixels.
        older: A frame from nearly the same pose.
    """
    if newer.hidden is None or newer.hidden.shape != older.depth.shape:
        return False
    return bool((newer.hidden & (older.depth > 0)).mean() > _HIDDEN_SHARE)


def frames_to_keep(
    X_WC: np.ndarray,
    most: int,
    hides: Callable[[int, int], bool] = lambda newer, older: False,
) -> np.ndarray:
    """Selects frames from different poses, and the newest ones.

    Of frames with nearly equal poses, the newest one is kept. An older one is
    also kept if the newest one masks surfaces that the older one shows. If more
    than `most` frames remain, only the newest `most` frames are kept.

    Args:
        X_WC: Poses of the cameras, oldest first, shape (n, 4, 4).
        most: At most this many frames are kept.
        hides: Function of the indices of two frames from nearly the same pose.
            It returns whether the first, newer frame masks surfaces of the
            second one.

    Returns:
        Indices of the frames to keep, ascending.
    """
    kept: list[int] = []
    for i in reversed(range(len(X_WC))):
        others = X_WC[kept]
        shift = np.linalg.norm(others[:, :3, 3] - X_WC[i, :3, 3], axis=1)
        # The trace of R_AB is 1 + 2 cos(angle).
        trace = np.einsum("kij,ij->k", others[:, :3, :3], X_WC[i, :3, :3])
        turn = np.arccos(np.clip((trace - 1) / 2, -1, 1))
        same = (shift < SAME_POSITION) & (turn < SAME_ROTATION)
        if all(hides(kept[j], i) for j in np.flatnonzero(same)):
            kept.append(i)
    return np.array(sorted(kept[:most]), int)


def contradicting_frames(capture: Capture, trusted: int) -> np.ndarray:
    """Finds new frames with wrong poses, which contradict the other frames.

    Args:
        capture: Frames that are already in a map, followed by new frames.
        trusted: Number of frames that are already in a map.

    Returns:
        Indices of the wrong frames, ascending.

    Raises:
        RemoSplatError: All frames are new and contradict each other, so it is
            unknown which of them are wrong.
    """
    wrong = wrong_frames(measure_overlap(capture))
    if not trusted and len(wrong) == len(capture) > 0:
        raise RemoSplatError(
            "the frames contradict each other: take more frames, or calibrate "
            "the camera again"
        )
    return wrong[wrong >= trusted]


def confirmed_frames(
    capture: Capture, base: GaussianSplat | None = None
) -> np.ndarray:
    """Finds the frames that other frames or the earlier map confirm.

    The pose of an unconfirmed frame may be wrong. So there may be an obstacle
    in space that the frame seems to show as free.

    Args:
        capture: The frames.
        base: The splat that was made before the frames, in W; None if there is
            none.

    Returns:
        A mask of the frames, shape (n,).
    """
    shares = supported_fractions(capture)
    if base is not None and len(base):
        shares = np.maximum(shares, shares_of(base, capture))
    return shares >= _MIN_SHARE


def contradiction(residual: float) -> str:
    """Returns the reason for the rejection of a frame that contradicts others.

    Args:
        residual: Median distance of the frame's surfaces from those of other
            frames [m]; NaN if not measured.
    """
    problem = "contradicts the other frames: its pose is wrong"
    if np.isfinite(residual):
        problem += f", its surfaces lie {1e3 * residual:.1f} mm from theirs"
    return problem
