"""Messages that identify a robot's controllers (sessions) and drivers.

Commands and statuses contain no identity of their sender. So ten times a
second, a session sends its lease, a message with its identity and the drivers
that must obey it. A driver sends a report with its identity and the session
that it follows. Each program sends leases or reports from the same UDP port as
its commands or statuses, so the address shows that they belong together.
"""

import dataclasses as dc
import os
import secrets
import socket
import time

from remosplat_drake.hardware.wire.messages.driver_report import driver_report
from remosplat_drake.hardware.wire.messages.operator_request import (
    operator_request,
)
from remosplat_drake.hardware.wire.messages.session_lease import session_lease
from remosplat_drake.hardware.wire.packets import decode, is_expired, to_utime

SESSION_LEASE = "SESSION_LEASE"
"""Channel of session_lease: the session that commands the robot."""
DRIVER_REPORT = "DRIVER_REPORT"
"""Channel of driver_report: the driver that moves the robot."""
OPERATOR_REQUEST = "OPERATOR_REQUEST"
"""Channel of operator_request: a person's permission for a session to move its
robot.
"""

PERIOD = 0.1
"""Time between two leases, and between two reports of a driver [s]."""

LEASE_EXPIRY = 1.0
"""A session's lease expires after this time without messages from it [s]."""

REQUEST_EXPIRY = 1.0
"""A request is ignored if its stamp differs from our clock by more than this
time [s]."""


@dc.dataclass(frozen=True)
class Identity:
    """The identity of one process on the LCM network.

    Attributes:
        session: Random number of the process; never 0.
        pid: Number of the process.
        host: Name of the process's computer.
        name: Name of the program, for display.
    """

    session: int
    pid: int
    host: str
    name: str

    @staticmethod
    def of_this_process(name: str) -> "Identity":
        """Returns a new identity of this process, with a name."""
        session = secrets.randbits(62) + 1
        return Identity(session, os.getpid(), socket.gethostname(), name)

    def __str__(self) -> str:
        return f"{self.name}, pid {self.pid} on {self.host}"


@dc.dataclass(frozen=True)
class Lease:
    """Message of a session that claims drivers.

    Attributes:
        identity: Identity of the session.
        sent: Number of commands sent so far.
        mode: Mode of the session's supervisor.
        reason: Reason for that mode.
        drivers: Session numbers of the drivers that must obey the session.
    """

    identity: Identity
    sent: int = 0
    mode: str = ""
    reason: str = ""
    drivers: tuple[int, ...] = ()


@dc.dataclass(frozen=True)
class Report:
    """Message of a driver about the session that it follows.

    Attributes:
        identity: Identity of the driver.
        holder: Session that the driver follows; 0 if it follows none.
        obeyed: Number of messages that the driver has accepted.
        refused: Number of messages that the driver has rejected.
        refused_from: Address of the sender whose message was rejected last;
            empty if none was rejected.
    """

    identity: Identity
    holder: int = 0
    obeyed: int = 0
    refused: int = 0
    refused_from: str = ""


def encode_lease(lease: Lease) -> bytes:
    """Encodes a lease, stamped now."""
    message = session_lease()
    _sign(message, lease.identity)
    message.sent = lease.sent
    message.mode, message.reason = lease.mode, lease.reason
    message.num_drivers = len(lease.drivers)
    message.drivers = list(lease.drivers)
    return message.encode()


def decode_lease(data: bytes) -> Lease:
    """Decodes a lease.

    Raises:
        BrokenMessage: The packet is not a lease.
    """
    message = decode(session_lease, data)
    return Lease(
        _signed(message),
        message.sent,
        message.mode,
        message.reason,
        tuple(message.drivers),
    )


def encode_report(report: Report) -> bytes:
    """Encodes a driver's report, stamped now."""
    message = driver_report()
    _sign(message, report.identity)
    message.holder = report.holder
    message.obeyed, message.refused = report.obeyed, report.refused
    message.refused_from = report.refused_from
    return message.encode()


def decode_report(data: bytes) -> Report:
    """Decodes a driver's report.

    Raises:
        BrokenMessage: The packet is not a report.
    """
    message = decode(driver_report, data)
    return Report(
        _signed(message),
        message.holder,
        message.obeyed,
        message.refused,
        message.refused_from,
    )


def encode_request(session: int, operator: str) -> bytes:
    """Encodes an operator's request, which permits a session to move.

    Args:
        session: The session.
        operator: Name of the person.
    """
    message = operator_request()
    message.utime = to_utime(time.time())
    message.session, message.operator = session, operator
    return message.encode()


def decode_request(data: bytes, session: int, now: float) -> str | None:
    """Returns the operator of a request; None if the request is ignored.

    Args:
        data: The encoded packet.
        session: The session of this process; requests to other sessions are
            ignored.
        now: Our wall clock [s]; a request whose stamp differs too much is
            ignored.

    Raises:
        BrokenMessage: The packet is not a request.
    """
    message = decode(operator_request, data)
    expired = is_expired(message.utime, to_utime(now), REQUEST_EXPIRY)
    if expired or message.session != session:
        return None
    return message.operator


def _sign(message, identity: Identity) -> None:
    message.utime = to_utime(time.time())
    message.session, message.pid = identity.session, identity.pid
    message.host, message.name = identity.host, identity.name


def _signed(message) -> Identity:
    return Identity(message.session, message.pid, message.host, message.name)
