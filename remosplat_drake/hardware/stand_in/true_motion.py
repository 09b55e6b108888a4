"""`TrueMotion`: records the true motion of the stand-in robot in a file."""

from pathlib import Path

import numpy as np

from remosplat_drake.base.atomic_file import atomic_write
from remosplat_drake.base.clock import wall_utime
from remosplat_drake.hardware.stand_in.robot_plant import RobotPlant
from remosplat_drake.hardware.wire.base import base_axes

PERIOD = 0.01
"""Time between two samples [s]."""


class TrueMotion:
    """Samples the plant's true configuration and velocity, at 100 Hz."""

    def __init__(self, plant: RobotPlant):
        """Starts without samples."""
        self._plant, self._axes = plant, base_axes(plant.robot.n_base)
        self._next = 0.0
        self._utime: list[int] = []
        self._q: list[np.ndarray] = []
        self._u: list[np.ndarray] = []

    def sample(self, t: float) -> None:
        """Takes a sample if one is due at the robot's time t [s]."""
        if t < self._next:
            return
        self._next += PERIOD
        plant = self._plant
        self._utime.append(wall_utime())
        self._q.append(plant.q)
        self._u.append(
            np.concatenate(
                [plant.base_velocity[self._axes], plant.arm.velocity]
            )
        )

    def save(self, path: Path) -> None:
        """Writes the samples as a NumPy .npz archive, atomically.

        Its arrays are utime (n,) [us], q (n, n_q) [m, rad] and u (n, n_u)
        [m/s, rad/s].
        """
        with atomic_write(path, "wb") as file:
            np.savez(file, utime=self._utime, q=self._q, u=self._u)
