"""`RosBase`: serves `BASE_COMMAND` with a mobile base that speaks ROS."""

import math
from collections import deque
from typing import Protocol

from pydrake.lcm import DrakeLcmInterface

from remosplat_drake.hardware.drivers.base_commands import (
    BaseCommands,
    BaseMaxima,
)
from remosplat_drake.hardware.drivers.ros_conversion import Odometry, status_of
from remosplat_drake.hardware.wire.channels import BASE_COMMAND, BASE_STATUS
from remosplat_drake.hardware.wire.inbox import CommandSource, Inbox

PERIOD = 0.01
"""Period of the bridge's loop [s]."""

FAREWELL = 0.5
"""How long zeros are sent after the last velocity that was not zero [s]. Then
the bridge is silent, so that others, a joystick say, may drive the base."""


class RosLink(Protocol):
    """What `RosBase` needs of ROS 1 or 2: cmd_vel to write, odom to read."""

    def publish(self, forward: float, yaw_rate: float) -> None:
        """Sends a Twist with these speeds [m/s, rad/s]."""
        ...

    def fetch(self) -> list[Odometry]:
        """Returns the odometry since the last call, oldest first."""
        ...

    def close(self) -> None:
        """Leaves the ROS network."""
        ...


class OdometryQueue:
    """Hands odometry from a thread of ROS over to the bridge's loop."""

    def __init__(self):
        """Starts empty."""
        self._messages: deque[Odometry] = deque(maxlen=100)

    def put(self, odometry: Odometry) -> None:
        """Adds a message; beyond 100 that wait, the oldest are dropped."""
        self._messages.append(odometry)

    def fetch(self) -> list[Odometry]:
        """Takes out all messages that wait, oldest first."""
        return [self._messages.popleft() for _ in range(len(self._messages))]


class RosBase:
    """Passes velocity commands from LCM to ROS, and odometry back."""

    def __init__(
        self,
        lcm: DrakeLcmInterface,
        link: RosLink,
        maxima: BaseMaxima | None = None,
        inbox: CommandSource | None = None,
    ):
        """Subscribes; nothing is sent before a command comes.

        Args:
            lcm: The LCM network.
            link: The connection to the base's ROS topics.
            maxima: Greatest velocities that are asked of the base; None
                takes the LD-60's.
            inbox: Where commands come from; None obeys everybody.
        """
        self._lcm = lcm
        self._link = link
        self._commands = BaseCommands(maxima)
        self._inbox = inbox or Inbox(lcm, [BASE_COMMAND])
        self._last_motion = -math.inf

    def step(self, now: int, t: float) -> None:
        """Runs one period of the bridge.

        Args:
            now: Wall clock [us].
            t: Time now, by a clock that never jumps [s].
        """
        for _, data in self._inbox.fetch():
            self._commands.receive(data, t)
        velocity = self._commands.velocity(now, t)
        if any(velocity):
            self._last_motion = t
        if t - self._last_motion <= FAREWELL:
            self._link.publish(*velocity)
        for odometry in self._link.fetch():
            status = status_of(odometry, now)
            if status is not None:
                self._lcm.Publish(BASE_STATUS, status.encode())

    def stop(self) -> None:
        """Tells the base to stand still, whatever it heard last."""
        self._link.publish(0.0, 0.0)
