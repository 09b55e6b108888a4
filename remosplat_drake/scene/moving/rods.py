"""`Rods`: capsules whose ends move along smooth curves, such as limbs."""

from collections.abc import Sequence

import numpy as np
import scipy
from pydrake.math import RigidTransform, RotationMatrix

from remosplat_drake.scene.mover import Mover
from remosplat_drake.scene.moving.track import SLACK

_LOOKS_A_KNOT = 4
"""To find the largest speed, the motion between two knots is sampled at this
many instants."""

_STEP = 1e-4
"""Time step for accelerations [s]."""


class Rods:
    """k rigid capsules that move smoothly through given positions.

    Cubic splines through the knots define the centres and the directions of the
    axes. The motion is therefore smooth, and reported velocities are exact
    derivatives. The rods rest before the first knot and after the last knot.

    Args:
        names: Display names of the k capsules.
        radius: Radii of the k capsules [m].
        times: The times of n knots, ascending [s].
        ends: Positions of their ends at the knots in W, shape (n, k, 2, 3) [m].
        max_speed: Speed limit of all points of their axes, as reported to the
            robot; None: the largest actual speed [m/s].
        max_acceleration: Acceleration limit of all points of their axes, as
            reported to the robot; None: the largest actual acceleration
            [m/s^2].
    """

    def __init__(
        self,
        names: Sequence[str],
        radius: Sequence[float],
        times: np.ndarray,
        ends: np.ndarray,
        max_speed: float | None = None,
        max_acceleration: float | None = None,
    ):
        self._names, self._radius = tuple(names), tuple(radius)
        self._span = float(times[0]), float(times[-1])
        self._length = np.linalg.norm(ends[:, :, 1] - ends[:, :, 0], axis=2)
        self._half_length = 0.5 * self._length.mean(axis=0)
        self._spline = scipy.interpolate.CubicSpline(
            times,
            np.stack([ends.mean(axis=2), ends[:, :, 1] - ends[:, :, 0]], 1),
            bc_type="clamped",
        )
        speed, push = self._greatest(_LOOKS_A_KNOT * len(times) + 1)
        self._speed = speed if max_speed is None else speed * 0.0 + max_speed
        self._push = push
        if max_acceleration is not None:
            self._push = push * 0.0 + max_acceleration

    def movers(self, time: float) -> list[Mover]:
        """Returns the capsules at a time.

        Args:
            time: Time since the run began [s].
        """
        now = float(np.clip(time, *self._span))
        center, z, v, w = self._motion(now)
        if now != time:
            v, w = np.zeros_like(v), np.zeros_like(w)
        return [
            Mover(
                name,
                RigidTransform(
                    RotationMatrix.MakeFromOneVector(z[i], 2), center[i]
                ),
                np.array([0.0, 0.0, self._half_length[i]]),
                self._radius[i],
                v[i],
                w[i],
                self._speed[i],
                self._push[i],
            )
            for i, name in enumerate(self._names)
        ]

    def _motion(self, time: np.ndarray | float) -> tuple[np.ndarray, ...]:
        """Centres, directions, velocities and angular velocities."""
        position, rate = self._spline(time), self._spline(time, 1)
        center, axis = position[..., 0, :, :], position[..., 1, :, :]
        length = np.linalg.norm(axis, axis=-1, keepdims=True)
        z = axis / length
        # Only the component of the axis' rate that is perpendicular to the axis
        # turns the capsule.
        w = np.cross(z, rate[..., 1, :, :] / length)
        return center, z, rate[..., 0, :, :], w

    def _greatest(self, looks: int) -> tuple[np.ndarray, np.ndarray]:
        """The greatest speeds and accelerations of the ends of the axes."""
        times = np.linspace(self._span[0], self._span[1] - _STEP, looks)
        now, then = (
            self._end_velocities(times),
            self._end_velocities(times + _STEP),
        )
        speed = np.linalg.norm(now, axis=-1).max(axis=(0, 1))
        push = np.linalg.norm((then - now) / _STEP, axis=-1).max(axis=(0, 1))
        return SLACK * speed, SLACK * push

    def _end_velocities(self, times: np.ndarray) -> np.ndarray:
        """Velocities of both ends, shape (2, n, k, 3) [m/s]."""
        _, z, v, w = self._motion(times)
        turn = np.cross(w, self._half_length[:, None] * z)
        return np.stack([v + turn, v - turn])
