"""Rules of a mobile base's driver for `BASE_COMMAND`: watchdog and limits.

There are two watchdogs: the base stops if the stamp of the latest command
expires, as for the arm, and if no command has arrived for 0.2 s. A command with
a braking ramp is instead held for 1.5 control periods, and followed by the ramp
to rest, which the controller has verified. A command beyond the maxima is
scaled to them. Otherwise the LD-60's ROS node would reject the command, and
would continue at the previous speed with its own watchdog disabled.
"""

import dataclasses as dc
import math

import numpy as np

from remosplat_drake.hardware.drivers.latest_ramp import LatestRamp
from remosplat_drake.hardware.wire.channels import COMMAND_EXPIRY, COMMAND_RAMP
from remosplat_drake.hardware.wire.command_limits import scaled_command
from remosplat_drake.hardware.wire.messages.base_command import base_command
from remosplat_drake.hardware.wire.packets import (
    BrokenMessage,
    decode,
    is_expired,
)

WATCHDOG = 0.2
"""The base stops after this time without a command [s]."""


@dc.dataclass(frozen=True)
class BaseMaxima:
    """Greatest velocities that a base executes.

    The defaults are those of the LD-60's ROS node. It rejects turning rates
    above 50 degrees per second (0.87266 rad/s), so the default is below this
    rate.

    Attributes:
        forward: Greatest speed forward [m/s].
        reverse: Greatest speed backwards [m/s]; it is low, since no sensor
            observes the space behind the base.
        sideways: Greatest speed to either side [m/s]. It is 0 for a base that
            cannot move sideways; a command with a sideways speed then becomes a
            stop.
        yaw_rate: Greatest turning rate, either way [rad/s].
    """

    forward: float = 1.0
    reverse: float = 0.25
    sideways: float = 0.0
    yaw_rate: float = 0.872


def clamped(velocity: np.ndarray, maxima: BaseMaxima) -> np.ndarray:
    """Scales down a command that exceeds the maxima; its arc stays the same.

    A command that is not finite becomes a stop.

    Args:
        velocity: Commanded speeds forward and to the left, and turning rate,
            shape (3,) [m/s, m/s, rad/s].
        maxima: The greatest velocities.

    Returns:
        The scaled command, shape (3,).
    """
    if not np.isfinite(velocity).all():
        return np.zeros(3)
    upper = np.array([maxima.forward, maxima.sideways, maxima.yaw_rate])
    lower = -np.array([maxima.reverse, maxima.sideways, maxima.yaw_rate])
    # Because of rounding, the scaled command may slightly exceed a bound.
    return np.clip(scaled_command(velocity, lower, upper), lower, upper)


class BaseCommands:
    """The base's latest velocity command, until it expires.

    Attributes:
        received: Number of valid commands so far.
    """

    def __init__(
        self,
        maxima: BaseMaxima | None = None,
        expiry: float = COMMAND_EXPIRY,
        watchdog: float = WATCHDOG,
    ):
        """Starts without a command.

        Args:
            maxima: Greatest velocities that are executed; if None, those of the
                LD-60.
            expiry: A command expires if its stamp differs from the driver's
                clock by more than this time [s].
            watchdog: The base stops after this time without a command [s].
        """
        self._maxima = maxima or BaseMaxima()
        self._expiry = expiry
        self._watchdog = watchdog
        self._utime = 0
        self._arrival = -math.inf
        self._velocity = np.zeros(3)
        self._ramp = LatestRamp()
        self._is_new = False
        self.received = 0

    def hear(self, channel: str, data: bytes, time: float) -> None:
        """Processes a command, or the ramp of the next command.

        Args:
            channel: `COMMAND_RAMP`, or the channel of the commands.
            data: The encoded packet; a malformed packet is ignored.
            time: Time now, by a monotonic clock [s].
        """
        if channel == COMMAND_RAMP:
            self._ramp.receive(data)
        else:
            self.receive(data, time)

    def receive(self, data: bytes, time: float) -> None:
        """Processes a command; a malformed command is ignored.

        Args:
            data: The encoded `base_command`.
            time: Time now, by a monotonic clock [s].
        """
        try:
            message = decode(base_command, data)
        except BrokenMessage:
            return
        self._utime = message.utime
        self._arrival, self._is_new = time, True
        velocity = np.array([message.forward, message.left, message.yaw_rate])
        self._velocity = clamped(velocity, self._maxima)
        self.received += 1

    def velocity(self, now: int, time: float) -> np.ndarray:
        """Returns the present setpoint; zero after the end of the command.

        Args:
            now: The driver's wall clock [us].
            time: Time now, by the same clock as for `receive` [s].

        Returns:
            Speeds forward and to the left, and turning rate, shape (3,)
            [m/s, m/s, rad/s].
        """
        share = self._share(now, time - self._arrival)
        self._is_new = False
        if not share:
            # An expired command is removed. Otherwise a command with a stamp in
            # the future would be executed later.
            self._velocity = np.zeros(3)
        return share * self._velocity

    def _share(self, now: int, silence: float) -> float:
        """Present factor by which the command is scaled, 0 to 1."""
        expired = is_expired(self._utime, now, self._expiry)
        ramp = self._ramp.of(self._utime)
        if ramp is None:
            return float(not (expired or silence > self._watchdog))
        if self._is_new and expired:
            return 0.0
        return ramp.share(silence)
