"""`SimulatedBase`: simulates a mobile base's driver, without dynamics.

The base is an Omron LD-60, or an omnidirectional base with the same
accelerations.
"""

import numpy as np

from remosplat_drake.hardware.drivers.base_commands import (
    BaseCommands,
    BaseMaxima,
)
from remosplat_drake.hardware.wire.messages.base_status import base_status

ACCELERATION = np.array([1.0, 1.0, np.pi])
"""Bounds on the base's acceleration and deceleration, forward, to the left and
about its axis [m/s^2, m/s^2, rad/s^2]."""

_SIDEWAYS = 0.5
"""Greatest speed of an omnidirectional base to either side [m/s]."""

PROTECTIVE_STOP = 2.0
"""Duration of a protective stop [s]."""

POSE_PERIOD = 0.027
"""Time between two statuses [s]; the real base sends poses at up to 37 Hz."""

TWIST_PERIOD = 0.1
"""Time between two measurements of the speed [s]."""

_STANDSTILL = 1e-3


class SimulatedBase:
    """Simulates a base's driver: converts commands to speeds and statuses.

    A protective stop ends by itself, and the base then follows commands again.
    An emergency stop is latched until `recover`, which represents the ON button
    of the robot.

    Attributes:
        commands: The driver's latest velocity command.
        emergency_stop: Whether an emergency stop is latched.
    """

    def __init__(self, is_omnidirectional: bool = False):
        """Starts ready, at rest.

        Args:
            is_omnidirectional: Whether the base can move sideways.
        """
        aside = _SIDEWAYS if is_omnidirectional else 0.0
        self.commands = BaseCommands(BaseMaxima(sideways=aside))
        self.emergency_stop = False
        self._protective_until = -np.inf
        self._velocity = np.zeros(3)
        self._twist = np.zeros(3)
        self._next_status = self._next_twist = 0.0

    def protective_stop(self, t: float) -> None:
        """Begins a protective stop at time t [s]."""
        self._protective_until = t + PROTECTIVE_STOP

    def recover(self) -> None:
        """Releases the emergency stop, like the ON button."""
        self.emergency_stop = False
        self._protective_until = -np.inf

    def step(self, now: int, t: float, dt: float) -> np.ndarray:
        """Advances the base's velocity by one step.

        Args:
            now: The driver's wall clock [us].
            t: The robot's clock, which never jumps [s].
            dt: Length of the step [s].

        Returns:
            Speeds forward and to the left, and turning rate, shape (3,)
            [m/s, m/s, rad/s].
        """
        target = self.commands.velocity(now, t)
        if self.emergency_stop or t < self._protective_until:
            target = np.zeros(3)
        change = ACCELERATION * dt
        self._velocity = self._velocity + np.clip(
            target - self._velocity, -change, change
        )
        return self._velocity

    def status(
        self, now: int, t: float, pose: np.ndarray, twist: np.ndarray
    ) -> base_status | None:
        """Returns the status message if one is due, else None.

        The speed in the status is the latest measurement, at 10 Hz.

        Args:
            now: The driver's wall clock [us].
            t: The robot's clock [s].
            pose: True x, y and yaw, shape (3,) [m, m, rad].
            twist: True speeds forward and to the left, and turning rate,
                shape (3,) [m/s, m/s, rad/s].
        """
        if t >= self._next_twist:
            self._next_twist += TWIST_PERIOD
            self._twist = twist
        if t < self._next_status:
            return None
        self._next_status += POSE_PERIOD
        message = base_status()
        message.utime = now
        message.pose = pose.tolist()
        message.forward, message.left, message.yaw_rate = map(
            float, self._twist
        )
        message.protective_stop = int(t < self._protective_until)
        message.emergency_stop = int(self.emergency_stop)
        message.mode = self._mode(message)
        message.battery = 1.0
        return message

    def _mode(self, message: base_status) -> int:
        if message.emergency_stop or message.protective_stop:
            return base_status.STOPPED
        moving = np.abs(self._velocity).max() > _STANDSTILL
        return base_status.MOVING if moving else base_status.READY
