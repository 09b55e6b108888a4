"""The mobile base driver's rules for `BASE_COMMAND`: watchdog and clamping.

Two watchdogs guard the base: stamps expire as the arm's do, and a base that
hears nothing for 0.2 s stops, also if its stamps are good. A command that came
with a ramp is held for 1.5 control periods instead, and then the ramp leads to
rest, as it was verified. A command beyond the maxima is clamped: the LD-60's
ROS node would reject it, and go on at the old speed with its own watchdog
disarmed.
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
"""Time without a command after which the base stops [s]."""


@dc.dataclass(frozen=True)
class BaseMaxima:
    """Greatest velocities that the base carries out.

    The defaults are those of the LD-60's ROS node. It turns down speeds that
    exceed 50 degrees a second, 0.87266 rad/s, so that a clamped command must
    stay below that.

    Attributes:
        forward: Greatest speed forward [m/s].
        reverse: Greatest speed backwards [m/s]; nothing looks back there.
        sideways: Greatest speed to either side [m/s]; 0 for a base that cannot
            move sideways: if commanded to, it stops.
        yaw_rate: Greatest turning rate, either way [rad/s].
    """

    forward: float = 1.0
    reverse: float = 0.25
    sideways: float = 0.0
    yaw_rate: float = 0.872


def clamped(velocity: np.ndarray, maxima: BaseMaxima) -> np.ndarray:
    """Scales a command as a whole into the maxima, so that its arc stays.

    A command that is not finite becomes a stop.

    Args:
        velocity: Commanded speeds forward and to the left, and turning rate,
            shape (3,) [m/s, m/s, rad/s].
        maxima: The greatest velocities.

    Returns:
        The same, shape (3,).
    """
    if not np.isfinite(velocity).all():
        return np.zeros(3)
    upper = np.array([maxima.forward, maxima.sideways, maxima.yaw_rate])
    lower = -np.array([maxima.reverse, maxima.sideways, maxima.yaw_rate])
    # Rounding may leave the multiple a bit beyond its bound.
    return np.clip(scaled_command(velocity, lower, upper), lower, upper)


class BaseCommands:
    """The base's latest velocity command, until it expires.

    Attributes:
        received: Number of good commands so far.
    """

    def __init__(
        self,
        maxima: BaseMaxima | None = None,
        expiry: float = COMMAND_EXPIRY,
        watchdog: float = WATCHDOG,
    ):
        """Starts without a command.

        Args:
            maxima: Greatest velocities that are carried out; None takes
                the LD-60's.
            expiry: Greatest difference between a stamp and the driver's
                clock [s].
            watchdog: Time without a command after which the base stops [s].
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
        """Takes in a command, or the ramp of the one that follows.

        Args:
            channel: The channel, `COMMAND_RAMP` or that of the commands.
            data: The encoded packet; a broken one is left aside.
            time: Time now, by a monotonic clock [s].
        """
        if channel == COMMAND_RAMP:
            self._ramp.receive(data)
        else:
            self.receive(data, time)

    def receive(self, data: bytes, time: float) -> None:
        """Takes in a message; a broken one is ignored.

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
        """Returns the velocity to aim for; zero once the command ended.

        Args:
            now: The driver's wall clock [us].
            time: Time now, by the clock that `receive` was given [s].

        Returns:
            Speeds forward and to the left, and turning rate, shape (3,)
            [m/s, m/s, rad/s].
        """
        share = self._share(now, time - self._arrival)
        self._is_new = False
        if not share:
            # Dropped for good: a stamp from the future must not count later.
            self._velocity = np.zeros(3)
        return share * self._velocity

    def _share(self, now: int, silence: float) -> float:
        """Share of the command that applies now."""
        expired = is_expired(self._utime, now, self._expiry)
        ramp = self._ramp.of(self._utime)
        if ramp is None:
            return float(not (expired or silence > self._watchdog))
        if self._is_new and expired:
            return 0.0
        return ramp.share(silence)
