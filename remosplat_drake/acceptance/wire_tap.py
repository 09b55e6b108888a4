"""`WireTap`: receives all messages at an LCM URL, and triggers faults."""

import struct
import time
from collections.abc import Callable

import numpy as np
from drake import lcmt_panda_command
from pydrake.lcm import DrakeLcm

from remosplat_drake.hardware.stand_in import faults
from remosplat_drake.hardware.wire import channels
from remosplat_drake.hardware.wire.inbox import Inbox
from remosplat_drake.hardware.wire.messages.base_command import base_command


class WireTap:
    """Receives the messages of robot and controller, and injects faults.

    Attributes:
        heard: Wall-clock time of the arm's latest status [s].
        moving_at: Wall-clock time of the first motion command [s]; None
            before.
        latest: Wall-clock time of the latest motion command [s].
    """

    def __init__(self, url: str):
        """Subscribes to all channels at an LCM URL."""
        self._lcm = DrakeLcm(url)
        self._inbox = Inbox(
            self._lcm,
            [
                channels.PANDA_COMMAND,
                channels.BASE_COMMAND,
                channels.PANDA_STATUS,
            ],
        )
        self.heard = -np.inf
        self.moving_at: float | None = None
        self.latest = -np.inf

    def wait(self, done: Callable[[], bool], limit: float) -> bool:
        """Listens until `done` is true, at most for `limit` [s].

        Returns:
            Whether it became true in time.
        """
        end = time.monotonic() + limit
        while not done():
            if time.monotonic() > end:
                return False
            self._listen()
        return True

    def listen_for(self, duration: float) -> None:
        """Listens for a duration [s]."""
        self.wait(lambda: False, duration)

    def inject(self, fault: str, value: float = 0.0) -> None:
        """Injects a fault with a name and a value into the simulated robot."""
        self._lcm.Publish(faults.CHANNEL, faults.encode_request(fault, value))

    def _listen(self) -> None:
        for channel, data in self._inbox.fetch(0.005):
            if channel == channels.PANDA_STATUS:
                self.heard = time.time()
            elif any(_velocities(channel, data)):
                self.latest = time.time()
                if self.moving_at is None:
                    self.moving_at = self.latest


def _velocities(channel: str, data: bytes) -> list[float]:
    """Commanded velocities; none in an invalid message."""
    try:
        if channel == channels.PANDA_COMMAND:
            return list(lcmt_panda_command.decode(data).joint_velocity)
        message = base_command.decode(data)
    except (ValueError, struct.error):
        return []
    return [message.forward, message.left, message.yaw_rate]
