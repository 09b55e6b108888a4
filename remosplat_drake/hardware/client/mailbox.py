"""`Mailbox`: stores the latest packet of an LCM channel."""

import math
import time

from pydrake.lcm import DrakeLcm

from remosplat_drake.hardware.wire.packets import from_utime, stamp_of


class Mailbox:
    """Stores the latest packet of an LCM channel, without decoding it.

    Between two calls of `HandleSubscriptions`, Drake's subscription stores only
    the first packet, and drops newer packets. So the mailbox receives a packet
    that arrived soon after the previous call. `RobotLink.flush` fetches a newer
    one.

    Attributes:
        channel: Name of the LCM channel.
        data: The latest packet, encoded; None before the first one.
        received: Time at which the mailbox received it, by our wall clock [s].
        count: Number of packets so far.
    """

    def __init__(self, lcm: DrakeLcm, channel: str):
        """Subscribes to a channel."""
        self.channel = channel
        self.data: bytes | None = None
        self.received = 0.0
        self.count = 0
        lcm.Subscribe(channel, self._receive)

    @property
    def stamp(self) -> float:
        """Stamp of the latest packet on the sender's wall clock [s].

        It is NaN before the first packet.
        """
        stamp = None if self.data is None else stamp_of(self.data)
        return math.nan if stamp is None else from_utime(stamp)

    def _receive(self, data: bytes) -> None:
        self.data = bytes(data)
        self.received = time.time()
        self.count += 1
