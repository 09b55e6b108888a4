"""`BaseDriver`: executes LCM commands on a velocity-controlled base."""

import math
from collections import deque
from collections.abc import Sequence
from typing import Generic, Protocol, TypeVar

import numpy as np
from pydrake.lcm import DrakeLcmInterface

from remosplat_drake.hardware.drivers.base_commands import (
    BaseCommands,
    BaseMaxima,
)
from remosplat_drake.hardware.drivers.base_stops import (
    BaseStops,
    StopSource,
    merged,
)
from remosplat_drake.hardware.drivers.ros_conversion import (
    Odometry,
    odometry_problem,
    status_of,
)
from remosplat_drake.hardware.drivers.topic_values import (
    TopicValues,
    expiry_of,
)
from remosplat_drake.hardware.ros_config import RosBase, Tell
from remosplat_drake.hardware.wire.channels import (
    BASE_COMMAND,
    BASE_LOCALIZATION,
    BASE_STATUS,
    COMMAND_RAMP,
)
from remosplat_drake.hardware.wire.inbox import CommandSource, Inbox
from remosplat_drake.hardware.wire.localization import (
    BaseFix,
    encode_localization,
)

PERIOD = 0.01
"""Period of the driver's loop [s]."""

FAREWELL = 0.5
"""Time for which zeros are sent after the last nonzero velocity [s]. After this
time, the driver sends nothing, so that another program, for example for a
joystick, may drive the base.
"""


class BaseLink(Protocol):
    """Protocol of a base that `BaseDriver` drives."""

    def publish(self, velocity: np.ndarray) -> None:
        """Sends a velocity to the base.

        Args:
            velocity: Speeds forward and to the left, and turning rate, shape
                (3,) [m/s, m/s, rad/s].
        """
        ...

    def fetch(self) -> list[Odometry]:
        """Returns the odometry since the last call, oldest first."""
        ...

    def fetch_fixes(self) -> list[BaseFix]:
        """Returns the localisations since the last call, oldest first."""
        ...

    def stops(self, t: float) -> BaseStops:
        """Returns the stops that the base's topics report at a time t [s]."""
        ...

    def close(self) -> None:
        """Disconnects from the base."""
        ...


Message = TypeVar("Message")


class Queue(Generic[Message]):
    """Passes messages from a ROS thread to the driver's loop."""

    def __init__(self):
        """Starts empty."""
        self._messages: deque[Message] = deque(maxlen=100)

    def put(self, message: Message) -> None:
        """Adds a message; at most the newest 100 messages are kept."""
        self._messages.append(message)

    def fetch(self) -> list[Message]:
        """Removes and returns all waiting messages, oldest first."""
        return [self._messages.popleft() for _ in range(len(self._messages))]


class StopFlags:
    """The latest values of topics that report whether the base may move."""

    def __init__(self, topics: RosBase):
        """Starts without values; a flag without a value is unknown."""
        self._fields = tuple(topics.flags.values())
        self._values = TopicValues[bool](expiry_of(topics.stop_expiry))

    def put(self, field: str, value: bool, t: float) -> None:
        """Stores a value of a topic.

        Args:
            field: Name of the topic's field in `RosBase`.
            value: Its value.
            t: Time of its arrival, by a monotonic clock [s].
        """
        self._values.put(field, bool(value), t)

    def stops(self, t: float) -> BaseStops:
        """Returns the base's stops; flags without recent values are unknown."""
        known = self._values.known(t)
        return BaseStops(
            emergency=known.get("emergency_stop", False),
            protective=known.get("protective_stop", False),
            motors_off=not known.get("motors_on", True),
            is_unknown=len(known) < len(self._fields),
        )


class BaseDriver:
    """Sends commands from LCM to a base, and publishes its measurements."""

    def __init__(
        self,
        lcm: DrakeLcmInterface,
        link: BaseLink,
        maxima: BaseMaxima | None = None,
        sources: Sequence[StopSource] = (),
        inbox: CommandSource | None = None,
        tell: Tell = lambda news: None,
    ):
        """Subscribes to commands; sends nothing before the first command.

        Args:
            lcm: The LCM network.
            link: The connection to the base.
            maxima: Greatest velocities of the base; if None, those of the
                LD-60.
            sources: Further sources of the base's stops, besides `link`.
            inbox: Source of commands. If it is None, commands of all senders
                are accepted.
            tell: Function that is called with a message when odometry is
                unusable.
        """
        self._tell, self._broken = tell, ""
        self._lcm = lcm
        self._link = link
        self._commands = BaseCommands(maxima)
        self._sources = (link, *sources)
        self._inbox = inbox or Inbox(lcm, [COMMAND_RAMP, BASE_COMMAND])
        self._last_motion = -math.inf

    def step(self, now: int, t: float) -> None:
        """Runs one period of the driver's loop.

        Args:
            now: Wall clock [us].
            t: Time now, by a monotonic clock [s].
        """
        for channel, data in self._inbox.fetch():
            self._commands.hear(channel, data, t)
        velocity = self._commands.velocity(now, t)
        if velocity.any():
            self._last_motion = t
        if t - self._last_motion <= FAREWELL:
            self._link.publish(velocity)
        stops = merged(source.stops(t) for source in self._sources)
        for odometry in self._link.fetch():
            problem = odometry_problem(odometry)
            if not problem:
                status = status_of(odometry, stops)
                self._lcm.Publish(BASE_STATUS, status.encode())
            elif problem != self._broken:
                self._broken = problem
                self._tell(f"{problem}; no status of the base is sent")
        for fix in self._link.fetch_fixes():
            if np.isfinite(fix.pose).all():
                self._lcm.Publish(BASE_LOCALIZATION, encode_localization(fix))

    def stop(self) -> None:
        """Sends a stop to the base, if a command was sent."""
        self._link.publish(np.zeros(3))
