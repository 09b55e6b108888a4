"""Which frames a map is made of."""

import numpy as np

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.checks.overlap import measure_overlap, wrong_frames

SAME_POSITION = 0.01
SAME_ROTATION = np.deg2rad(2.0)
"""Cameras that differ by less see the same [m], [rad]."""


def frames_to_keep(X_WC: np.ndarray, most: int) -> np.ndarray:
    """Of nearly equal poses the newest, and the newest of all.

    Args:
        X_WC: Poses of the cameras, oldest first, shape (n, 4, 4).
        most: At most as many are kept.

    Returns:
        Ascending indices.
    """
    kept: list[int] = []
    for i in reversed(range(len(X_WC))):
        others = X_WC[kept]
        shift = np.linalg.norm(others[:, :3, 3] - X_WC[i, :3, 3], axis=1)
        # The trace of R_AB is 1 + 2 cos(angle).
        trace = np.einsum("kij,ij->k", others[:, :3, :3], X_WC[i, :3, :3])
        turn = np.arccos(np.clip((trace - 1) / 2, -1, 1))
        if not ((shift < SAME_POSITION) & (turn < SAME_ROTATION)).any():
            kept.append(i)
    return np.array(sorted(kept[:most]), int)


def contradicting_frames(capture: Capture, trusted: int) -> np.ndarray:
    """New frames that fit nowhere: where their poses are wrong.

    Args:
        capture: Frames that are in a map already, then new ones.
        trusted: How many are in a map.

    Returns:
        Ascending indices.

    Raises:
        RemoSplatError: All are new and contradict each other, so that nobody
            knows which of them is wrong.
    """
    wrong = wrong_frames(measure_overlap(capture))
    if not trusted and len(wrong) == len(capture) > 0:
        raise RemoSplatError(
            "the frames contradict each other: more of them are needed, or"
            " the camera's calibration is wrong"
        )
    return wrong[wrong >= trusted]
