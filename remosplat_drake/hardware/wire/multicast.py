"""`MulticastListener`: receives LCM packets with senders and arrival times.

LCM does not report the sender of a message. But the address of the UDP packet
identifies the sender, since each process sends from its own port. The kernel
stamps each packet on arrival, so messages do not seem late if the listener is
busy.

The format is LCM's (`lcm_udpm.c`), big-endian: the magic number LC02, a
sequence number, the zero-terminated name of the channel, and the message.
Messages of more than 64 kB are split into fragments (LC03). Commands and
statuses are smaller, so a filter in the kernel drops fragments.
"""

import contextlib
import ctypes
import math
import re
import socket
import struct
import time
from typing import NamedTuple

from remosplat_drake.base.errors import RemoSplatError

_MAGIC = 0x4C433032  # LC02.
_HEADER = struct.Struct(">II")

_LARGEST = 1 << 16
_BUFFER = 1 << 21
"""Requested size of the kernel's receive buffer [bytes]. The kernel may
allocate less.
"""

_MOST = 1000
"""At most this many packets are returned per call, so that a flood does not
block the listener."""

_UDP_HEADER = 8
_ATTACH_FILTER = getattr(socket, "SO_ATTACH_FILTER", 26)

_TIMESTAMP = getattr(socket, "SO_TIMESTAMPNS", 35)
_TIMESPEC = struct.Struct("@ll")  # Seconds and nanoseconds.
_CONTROL = socket.CMSG_SPACE(_TIMESPEC.size)


class Packet(NamedTuple):
    """An LCM message, with its sender and the time of its arrival.

    Attributes:
        channel: Name of the message's channel, including its suffix.
        data: The encoded message.
        sender: Address of the process that sent it, `IP:PORT`.
        received: Time of arrival at this computer, by the wall clock [s]; NaN
            if unknown.
    """

    channel: str
    data: bytes
    sender: str
    received: float = math.nan


class MulticastListener:
    """Receives all small messages of an LCM network."""

    def __init__(self, url: str):
        """Joins the multicast group.

        Args:
            url: For example `udpm://239.255.76.67:7667?ttl=0`.

        Raises:
            RemoSplatError: The URL is not of this form, or the group cannot be
                joined.
        """
        match = re.match(r"udpm://([\d.]+):(\d+)", url)
        if match is None:
            raise RemoSplatError(
                f"LCM URL {url!r}: is not a multicast address; use"
                " udpm://ADDRESS:PORT"
            )
        try:
            self._socket = _joined(match[1], int(match[2]))
        except OSError as error:
            raise RemoSplatError(f"LCM URL {url!r}: {error}") from error
        # Packets come from few senders, so the names of senders are cached.
        self._names: dict[tuple, str] = {}

    def fetch(self) -> list[Packet]:
        """Removes and returns the packets that have arrived, oldest first."""
        packets = []
        for _ in range(_MOST):
            try:
                datagram, told, _, address = self._socket.recvmsg(
                    _LARGEST, _CONTROL
                )
            except (BlockingIOError, InterruptedError):
                break
            message = parsed(datagram)
            if message is not None:
                name = self._name(address)
                packets.append(Packet(*message, name, _arrival(told)))
        return packets

    def close(self) -> None:
        """Leaves the group."""
        self._socket.close()

    def _name(self, address: tuple) -> str:
        if address not in self._names:
            if len(self._names) > _MOST:
                self._names.clear()
            self._names[address] = "{}:{}".format(*address)
        return self._names[address]


def parsed(datagram: bytes) -> tuple[str, bytes] | None:
    """Returns channel and message of a datagram; None if it is not LCM's.

    Args:
        datagram: The content of a UDP packet.
    """
    end = datagram.find(b"\0", _HEADER.size)
    if end < 0 or _HEADER.unpack_from(datagram)[0] != _MAGIC:
        return None
    channel = datagram[_HEADER.size : end].decode("ascii", "replace")
    return channel, datagram[end + 1 :]


def _arrival(told: list[tuple[int, int, bytes]]) -> float:
    """Time of arrival by the kernel [s]; now if the kernel sends none."""
    for level, kind, data in told:
        if (level, kind) == (socket.SOL_SOCKET, _TIMESTAMP):
            seconds, nanoseconds = _TIMESPEC.unpack(data)
            return seconds + 1e-9 * nanoseconds
    return time.time()


def _joined(group: str, port: int) -> socket.socket:
    """Opens a socket that receives a multicast group and does not block."""
    joined = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    joined.setblocking(False)
    joined.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    joined.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _BUFFER)
    with contextlib.suppress(OSError):
        joined.setsockopt(socket.SOL_SOCKET, _TIMESTAMP, 1)
    _drop_fragments(joined)
    joined.bind((group, port))
    member = struct.pack(
        "4s4s", socket.inet_aton(group), socket.inet_aton("0.0.0.0")
    )
    joined.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, member)
    return joined


def _drop_fragments(joined: socket.socket) -> None:
    """Filters fragments of images in the kernel: packets without LC02.

    If the kernel does not support such filters, all packets are received.
    """
    instructions = (
        (0x20, 0, 0, _UDP_HEADER),  # Load the word behind the UDP header;
        (0x15, 0, 1, _MAGIC),  # if it is the magic,
        (0x06, 0, 0, _LARGEST),  # keep the packet,
        (0x06, 0, 0, 0),  # else drop it.
    )
    program = b"".join(struct.pack("=HBBI", *i) for i in instructions)
    code = ctypes.create_string_buffer(program)
    header = struct.pack("@HP", len(instructions), ctypes.addressof(code))
    with contextlib.suppress(OSError):
        joined.setsockopt(socket.SOL_SOCKET, _ATTACH_FILTER, header)
