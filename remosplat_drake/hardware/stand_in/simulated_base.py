"""`SimulatedBase`: the Omron LD-60 and its driver, without rigid bodies."""

import numpy as np

from remosplat_drake.hardware.drivers.base_commands import BaseCommands
from remosplat_drake.hardware.wire.messages.base_status import base_status

ACCELERATION = np.array([1.0, np.pi])
"""What the base accelerates and brakes with, forward and about its axis
[m/s^2, rad/s^2]."""

PROTECTIVE_STOP = 2.0
"""How long a protective stop lasts before the motors return [s]."""

POSE_PERIOD = 0.027
"""Time between two statuses: the pose comes at 37 Hz at best [s]."""

TWIST_PERIOD = 0.1
"""Time between two measurements of the speed [s]."""

_STANDSTILL = 1e-3


class SimulatedBase:
    """Commands in, speeds and statuses out, a millisecond a call.

    A protective stop ends by itself and the base then follows the commands
    it hears; an emergency stop needs `recover`, the button on the robot.
    """

    def __init__(self):
        """Starts ready, at rest."""
        self.commands = BaseCommands()
        self.emergency_stop = False
        self._protective_until = -np.inf
        self._velocity = np.zeros(2)
        self._twist = (0.0, 0.0)
        self._next_status = self._next_twist = 0.0

    def protective_stop(self, t: float) -> None:
        """Something entered the scanner's field at time t [s]."""
        self._protective_until = t + PROTECTIVE_STOP

    def recover(self) -> None:
        """The emergency stop is released and the ON button pressed."""
        self.emergency_stop = False
        self._protective_until = -np.inf

    def step(self, now: int, t: float, dt: float) -> np.ndarray:
        """Forward speed and yaw rate of the next step, shape (2,).

        Args:
            now: The driver's wall clock [us].
            t: The robot's clock, which never jumps [s].
            dt: Length of the step [s].
        """
        target = np.array(self.commands.velocity(now, t))
        if self.emergency_stop or t < self._protective_until:
            target = np.zeros(2)
        change = ACCELERATION * dt
        self._velocity = self._velocity + np.clip(
            target - self._velocity, -change, change
        )
        return self._velocity

    def status(
        self, now: int, t: float, pose: np.ndarray, twist: np.ndarray
    ) -> base_status | None:
        """The status message if one is due, with the speed measured last.

        Args:
            now: The driver's wall clock [us].
            t: The robot's clock [s].
            pose: x, y, yaw, shape (3,) [m, m, rad].
            twist: Forward speed and yaw rate, shape (2,) [m/s, rad/s].
        """
        if t >= self._next_twist:
            self._next_twist += TWIST_PERIOD
            self._twist = (float(twist[0]), float(twist[1]))
        if t < self._next_status:
            return None
        self._next_status += POSE_PERIOD
        message = base_status()
        message.utime = now
        message.pose = pose.tolist()
        message.forward, message.yaw_rate = self._twist
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
