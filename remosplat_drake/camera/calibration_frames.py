"""Collects frames for a hand-eye calibration while a person moves the robot."""

import time
from collections.abc import Callable
from pathlib import Path
from typing import Protocol

import numpy as np
from scipy.spatial.transform import Rotation

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.frames import Frame, assemble

APART = np.deg2rad(8.0)
"""The camera's orientations differ by at least this angle between any two
frames that are kept [rad].
"""

_STILL_TURN, _STILL = np.deg2rad(0.1), 1e-3
"""A robot counts as at rest if it moves by at most this between two images
[rad, m]."""


_SILENCE = 10.0
"""The collection fails after this time without a usable image [s]."""


class Camera(Protocol):
    """A source of frames, such as an `LcmCamera`."""

    def frame(self, q: np.ndarray, time: float) -> Frame:
        """Waits for the next frame."""
        ...


def collect_still_frames(
    camera: Camera,
    count: int,
    on_frame: Callable[[int], bool],
) -> Capture:
    """Collects frames from different poses, each while the robot is at rest.

    A person moves the robot between the frames, by hand or by teleoperation.
    Images without a pose are skipped; they occur if the camera or the robot
    does not send for a short time.

    Args:
        camera: The robot's camera.
        count: Number of frames.
        on_frame: Function that is called after each image with the number of
            frames so far. It returns whether to continue.

    Returns:
        The frames that were taken: `count`, or fewer if `on_frame` ended the
        collection.

    Raises:
        RemoSplatError: The camera or the robot has stopped sending.
    """
    frames: list[Frame] = []
    last: Frame | None = None
    heard = time.monotonic()
    while on_frame(len(frames)) and len(frames) < count:
        try:
            frame = camera.frame(np.zeros(0), 0.0)
        except RemoSplatError:
            if time.monotonic() - heard > _SILENCE:
                raise
            continue
        heard = time.monotonic()
        stands = last is not None and _stands(last.X_WC, frame.X_WC)
        if stands and all(_turn(f.X_WC, frame.X_WC) > APART for f in frames):
            frames.append(frame)
        last = frame
    return assemble(Path("live frames"), frames)


def _turn(X_WA: np.ndarray, X_WB: np.ndarray) -> float:
    """Angle between the rotations of two poses [rad]."""
    R_AB = X_WA[:3, :3].T @ X_WB[:3, :3]
    return float(Rotation.from_matrix(R_AB).magnitude())


def _stands(X_WA: np.ndarray, X_WB: np.ndarray) -> bool:
    p = np.linalg.norm(X_WA[:3, 3] - X_WB[:3, 3])
    return bool(p < _STILL and _turn(X_WA, X_WB) < _STILL_TURN)
