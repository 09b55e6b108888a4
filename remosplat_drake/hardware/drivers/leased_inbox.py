"""`LeasedInbox`: accepts a driver's commands from one controller at a time.

Each controller has a session, and claims drivers by messages called leases. A
driver accepts commands only from the session whose lease names the driver. It
identifies that session by the sender's address. It releases the session when
its leases no longer name the driver, or after `LEASE_EXPIRY` without a message.
Commands from other sessions are rejected, counted and reported.
"""

import dataclasses as dc
import math
import time
from collections.abc import Callable, Collection

from pydrake.lcm import DrakeLcm

from remosplat_drake.hardware.wire.lease import (
    DRIVER_REPORT,
    LEASE_EXPIRY,
    PERIOD,
    SESSION_LEASE,
    Identity,
    Lease,
    Report,
    decode_lease,
    encode_report,
)
from remosplat_drake.hardware.wire.multicast import MulticastListener
from remosplat_drake.hardware.wire.packets import BrokenMessage

_YIELD = 5e-4
"""An inbox that waits for messages polls once in this time [s]."""


@dc.dataclass(frozen=True)
class Hold:
    """The session that a driver follows.

    Attributes:
        lease: The session's latest lease; None if the driver follows no
            session.
        sender: Address from which the session sends its lease and its commands.
        heard: Time of the session's last message, by a monotonic clock [s].
    """

    lease: Lease | None = None
    sender: str = ""
    heard: float = -math.inf

    def after_lease(
        self, lease: Lease, sender: str, driver: int, now: float
    ) -> "Hold":
        """Returns the followed session after a lease.

        Args:
            lease: The lease.
            sender: Address from which the lease came.
            driver: The driver's own session.
            now: Time now, by a monotonic clock [s].
        """
        current = self.at(now).lease
        is_same = current is not None and current.identity == lease.identity
        if driver in lease.drivers and (current is None or is_same):
            return Hold(lease, sender, now)
        return Hold() if is_same else self

    def after_command(self, sender: str, now: float) -> "Hold":
        """Returns the followed session after a command from an address."""
        if self.admits(sender, now):
            return dc.replace(self, heard=now)
        return self

    def at(self, now: float) -> "Hold":
        """Returns the followed session at a time, none after `LEASE_EXPIRY`."""
        return self if now - self.heard <= LEASE_EXPIRY else Hold()

    def admits(self, sender: str, now: float) -> bool:
        """Returns whether a command from an address is accepted."""
        return self.at(now).lease is not None and sender == self.sender


class LeasedInbox:
    """Receives the messages for a driver, and returns the accepted ones.

    It replaces an `Inbox`. A driver must call `fetch` continuously, since
    `fetch` also sends the reports.
    """

    def __init__(
        self,
        lcm: DrakeLcm,
        channels: Collection[str],
        *,
        name: str,
        open_channels: Collection[str] = (),
        on_news: Callable[[str], None] = lambda news: None,
        clock: Callable[[], float] = time.monotonic,
    ):
        """Joins the LCM network.

        Args:
            lcm: The LCM network, on which the driver also sends its statuses.
            channels: Channels of commands, which need a lease.
            name: Name of the driver, for display.
            open_channels: Channels for which no lease is needed.
            on_news: Function that is called with a text when the driver follows
                another session, and when it first rejects a session.
            clock: A monotonic clock [s].

        Raises:
            RemoSplatError: The LCM URL is not a multicast address.
        """
        self.identity = Identity.of_this_process(name)
        self._lcm = lcm
        self._listener = MulticastListener(lcm.get_lcm_url())
        self._channels, self._open = set(channels), set(open_channels)
        self._on_news, self._clock = on_news, clock
        self._hold = Hold()
        self._report = Report(self.identity)
        self._reported = -math.inf
        self._strangers: set[str] = set()

    def fetch(self, timeout: float = 0.0) -> list[tuple[str, bytes]]:
        """Removes and returns the accepted messages.

        Args:
            timeout: Longest wait for the first message [s].

        Returns:
            Pairs of a channel's name and an encoded message, oldest first.
        """
        end = self._clock() + timeout
        while True:
            messages = self._look()
            if messages or self._clock() >= end:
                return messages
            time.sleep(_YIELD)

    def _look(self) -> list[tuple[str, bytes]]:
        now, messages = self._clock(), []
        for channel, data, sender, _ in self._listener.fetch():
            if channel == SESSION_LEASE:
                self._hear(data, sender, now)
            elif channel in self._open:
                messages.append((channel, data))
            elif channel in self._channels:
                self._hold = self._hold.after_command(sender, now)
                if self._hold.admits(sender, now):
                    messages.append((channel, data))
                else:
                    self._refuse(channel, sender)
        self._tell(now, len(messages))
        return messages

    def _hear(self, data: bytes, sender: str, now: float) -> None:
        try:
            lease = decode_lease(data)
        except BrokenMessage:
            self._refuse(SESSION_LEASE, sender)
            return
        before = self._hold.at(now)
        hold = before.after_lease(lease, sender, self.identity.session, now)
        self._hold = hold
        if hold.lease and (before.lease is None):
            self._on_news(f"follows {hold.lease.identity}, at {sender}")

    def _refuse(self, channel: str, sender: str) -> None:
        self._report = dc.replace(
            self._report,
            refused=self._report.refused + 1,
            refused_from=sender,
        )
        if sender not in self._strangers and len(self._strangers) < 100:
            self._strangers.add(sender)
            self._on_news(f"refuses {channel} from {sender}")

    def _tell(self, now: float, obeyed: int) -> None:
        """Sends a report on this driver and its session, ten times a second."""
        lease = self._hold.at(now).lease
        self._report = dc.replace(
            self._report,
            holder=lease.identity.session if lease else 0,
            obeyed=self._report.obeyed + obeyed,
        )
        if now - self._reported >= PERIOD:
            self._reported = now
            self._lcm.Publish(DRIVER_REPORT, encode_report(self._report))
