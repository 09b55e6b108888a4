"""`MotionHistory`: computes the robot's configuration at an image's time."""

import bisect
import contextlib
from collections import deque

import numpy as np

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.hardware.wire.base import decode_base_status
from remosplat_drake.hardware.wire.packets import BrokenMessage
from remosplat_drake.hardware.wire.panda import decode_panda_status

_LENGTH = 1000
"""For the arm and for the base, at most this many statuses are stored. They
cover some seconds."""

_MAX_GAP = 0.12
"""A motion between two statuses is interpolated if the time between them is at
most this [s].
"""

_STANDING = 1e-3
"""A robot was at rest between two statuses if its positions changed by at most
this [rad, m]."""


class MotionHistory:
    """Interpolates the robot's configuration in the recent past.

    It stores the latest statuses of arm and base with their drivers' stamps.
    """

    def __init__(self, n_arm: int, has_base: bool):
        """Starts without any status.

        Args:
            n_arm: Number of the arm's joints.
            has_base: Whether the arm is on a mobile base.
        """
        self._n_arm = n_arm
        self._arm = _Track("the arm")
        self._base = _Track("the base") if has_base else None

    def hear_arm(self, data: bytes) -> None:
        """Stores an encoded status of the arm; ignores a malformed status."""
        with contextlib.suppress(BrokenMessage):
            arm = decode_panda_status(data, self._n_arm)
            self._arm.append(arm.stamp, arm.q)

    def hear_base(self, data: bytes) -> None:
        """Stores an encoded status of the base; ignores a malformed status."""
        if self._base is None:
            return
        with contextlib.suppress(BrokenMessage):
            base = decode_base_status(data)
            self._base.append(base.stamp, base.pose)

    @property
    def newest(self) -> float:
        """Latest stamp for which statuses of both arm and base exist [s].

        It is -inf until both have sent a status.
        """
        tracks = [self._arm] if self._base is None else [self._arm, self._base]
        return min(track.newest for track in tracks)

    def at(self, time: float, ahead: float = 0.0) -> np.ndarray:
        """Interpolates the configuration at a time.

        Args:
            time: Wall clock of the drivers [s].
            ahead: A motion is extrapolated beyond the newest status by at most
                this time [s].

        Returns:
            The configuration q, shape (n_q,) [m, rad].

        Raises:
            RemoSplatError: Arm or base sent no status around this time, or
                moved during a gap between two statuses.
        """
        joints = self._arm.at(time, ahead)
        if self._base is None:
            return joints
        return np.concatenate([self._base.at(time, ahead), joints])


class _Track:
    """Positions of the arm or the base, with their stamps."""

    def __init__(self, name: str):
        self._name = name
        self._stamps: deque[float] = deque(maxlen=_LENGTH)
        self._positions: deque[np.ndarray] = deque(maxlen=_LENGTH)

    @property
    def newest(self) -> float:
        return self._stamps[-1] if self._stamps else -np.inf

    def append(self, stamp: float, positions: np.ndarray) -> None:
        """Stores a position if it is newer than all stored ones."""
        if stamp > self.newest:
            self._stamps.append(stamp)
            self._positions.append(positions)

    def at(self, time: float, ahead: float) -> np.ndarray:
        after = max(1, bisect.bisect_left(self._stamps, time))
        if after > 1 and time <= self.newest + ahead:
            after = min(after, len(self._stamps) - 1)
        if after >= len(self._stamps) or time < self._stamps[0]:
            raise RemoSplatError(
                f"{self._name} sent no status when the image was taken"
            )
        start, end = self._stamps[after - 1], self._stamps[after]
        q, step = self._positions[after - 1], self._step(after)
        if end - start > _MAX_GAP and np.abs(step).max() > _STANDING:
            raise RemoSplatError(
                f"{self._name} moved, and sent no status around the time "
                "when the image was taken"
            )
        return q + (time - start) / (end - start) * step

    def _step(self, after: int) -> np.ndarray:
        """Change since the previous position; angles change by at most pi."""
        step = self._positions[after] - self._positions[after - 1]
        return (step + np.pi) % (2 * np.pi) - np.pi
