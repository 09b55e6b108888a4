"""`BaseSenses`: odometry and localisation of the stand-in's base."""

import numpy as np

from remosplat_drake.base.clock import MICROSECONDS
from remosplat_drake.hardware.localization_config import LocalizationConfig
from remosplat_drake.hardware.stand_in.faults import FaultSchedule
from remosplat_drake.hardware.wire.localization import (
    BaseFix,
    encode_localization,
)
from remosplat_drake.hardware.wire.messages.base_status import base_status
from remosplat_drake.robot.planar_pose import relative

X_WO = np.array([0.3, -0.2, 0.1])
"""Initial pose of the odometry if there is a localisation: x, y, yaw in W,
shape (3,) [m, m, rad].
"""

FIX_PERIOD = 0.1
"""Time between two fixes of the localisation [s]."""

FIX_DELAY = 0.05
"""Age of a fix when it is sent [s]."""

DEVIATION = np.array([0.002, 0.002, 0.001])
"""Standard deviations of a fix [m, m, rad]."""

AWAY = np.array([-1.0, 0.0, 0.0])
"""Direction of jumps and drift. Shipped scenes are in front of the base, in the
direction of x, so because of such a fault they seem farther away than they are.
"""


class BaseSenses:
    """Simulates the odometry of a base and, if requested, its localisation.

    Without a localisation, the odometry is the pose in W.
    """

    def __init__(self, localizes: bool, X_WO: np.ndarray = X_WO, seed: int = 0):
        """Starts without errors.

        Args:
            localizes: Whether there is a localisation in addition to the
                odometry.
            X_WO: Pose of the odometry's frame at the start, if there is a
                localisation, shape (3,) [m, m, rad].
            seed: Seed of the localisation's noise.
        """
        self._localizes, self._X_WO = localizes, X_WO
        self._drifts = {"base-drift": 0.0, "localization-drift": 0.0}
        self._time = self._next_fix = 0.0
        self._fixes: list[tuple[float, BaseFix]] = []
        self._random = np.random.default_rng(seed)

    def advance(self, t: float, faults: FaultSchedule) -> None:
        """Advances the drifts to a time t [s]."""
        for name in self._drifts:
            self._drifts[name] += faults.value(name, 0.0) * (t - self._time)
        self._time = t

    def spoil(self, status: base_status, faults: FaultSchedule) -> None:
        """Replaces the true pose in a status by the odometry's, in place."""
        off = self._drifts["base-drift"] + faults.value("base-jump", 0.0)
        pose = np.array(status.pose) + off * AWAY
        status.pose = (
            relative(self._X_WO, pose) if self._localizes else pose
        ).tolist()
        status.utime += round(faults.value("base-clock", 0.0) * MICROSECONDS)
        if "base-mute" in faults:
            status.protective_stop = status.emergency_stop = 0
            is_stopped = status.mode == base_status.STOPPED
            status.mode = base_status.READY if is_stopped else status.mode

    def fix(
        self, now: int, t: float, pose: np.ndarray, faults: FaultSchedule
    ) -> bytes | None:
        """Returns a message of the localisation if one is due, else None.

        Args:
            now: The robot's wall clock [us].
            t: The robot's clock [s].
            pose: True x, y and yaw, shape (3,) [m, m, rad].
            faults: The present faults.
        """
        if self._localizes and t >= self._next_fix:
            self._next_fix += FIX_PERIOD
            self._fixes.append((t, self._measured(now, pose, faults)))
        if not self._fixes or t < self._fixes[0][0] + FIX_DELAY:
            return None
        _, fix = self._fixes.pop(0)
        silent = "localization-stops" in faults
        return None if silent else encode_localization(fix)

    def _measured(
        self, now: int, pose: np.ndarray, faults: FaultSchedule
    ) -> BaseFix:
        off = self._drifts["localization-drift"]
        off += faults.value("localization-jump", 0.0)
        frames = LocalizationConfig()
        strange = "localization-frame" in faults
        return BaseFix(
            pose + off * AWAY + DEVIATION * self._random.normal(size=3),
            np.diag(DEVIATION**2),
            now / MICROSECONDS,
            frames.odometry_frame if strange else frames.map_frame,
            frames.base_frame,
        )
