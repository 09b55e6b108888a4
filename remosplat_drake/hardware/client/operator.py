"""`Operator`: sends a person's permission to move robots to controllers."""

import getpass
import socket
import time

from pydrake.lcm import DrakeLcm

from remosplat_drake.hardware.wire.lease import (
    LEASE_EXPIRY,
    OPERATOR_REQUEST,
    SESSION_LEASE,
    Lease,
    decode_lease,
    encode_request,
)
from remosplat_drake.hardware.wire.multicast import MulticastListener
from remosplat_drake.hardware.wire.packets import BrokenMessage

_YIELD = 5e-3
"""Packets are processed once in this time [s]."""


class Operator:
    """Lists the sessions that command robots, and arms a selected session."""

    def __init__(self, lcm: DrakeLcm):
        """Joins the LCM network.

        Args:
            lcm: The network of the controllers.

        Raises:
            RemoSplatError: The LCM URL is not a multicast address.
        """
        self._lcm = lcm
        self._listener = MulticastListener(lcm.get_lcm_url())
        self._heard: dict[int, tuple[float, Lease]] = {}

    def leases(self) -> list[Lease]:
        """Returns the latest lease message of each present session."""
        now = time.monotonic()
        for channel, data, *_ in self._listener.fetch():
            if channel == SESSION_LEASE:
                try:
                    lease = decode_lease(data)
                except BrokenMessage:
                    continue
                self._heard[lease.identity.session] = now, lease
        return [
            lease
            for heard, lease in self._heard.values()
            if now - heard <= LEASE_EXPIRY
        ]

    def listen_for(self, duration: float) -> list[Lease]:
        """Receives leases for a duration [s]; returns the present sessions."""
        end = time.monotonic() + duration
        while time.monotonic() < end:
            self.leases()
            time.sleep(_YIELD)
        return self.leases()

    def arm(self, session: int) -> None:
        """Permits a session to move its robot, also after a stop.

        Args:
            session: The number of the session, from its lease.
        """
        name = f"{getpass.getuser()}@{socket.gethostname()}"
        self._lcm.Publish(OPERATOR_REQUEST, encode_request(session, name))
