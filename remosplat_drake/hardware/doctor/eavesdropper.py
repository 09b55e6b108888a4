"""`Eavesdropper`: hears LCM packets together with who sent them.

LCM itself tells no listener where a message came from. A packet begins with
"LC02", a sequence number and the channel's name, ended by a zero byte; the
first one of a message in fragments with "LC03" and five more numbers.
"""

import dataclasses as dc
import re
import select
import socket
import struct
import time
from collections.abc import Iterator

from remosplat_drake.base.errors import RemoSplatError

_SHORT, _FRAGMENT = b"LC02", b"LC03"
_SHORT_HEADER = struct.Struct(">4sI")
_FRAGMENT_HEADER = struct.Struct(">4sIIIHH")
_LARGEST = 1 << 16


@dc.dataclass(frozen=True)
class Packet:
    """A packet as it was heard.

    Attributes:
        sender: Address and port of the sender; each LCM object has its own.
        channel: Name of the LCM channel.
        data: The encoded message; cut short for one in fragments.
        received: When it came, by our wall clock [s].
    """

    sender: tuple[str, int]
    channel: str
    data: bytes
    received: float


def parse_packet(datagram: bytes) -> tuple[str, bytes] | None:
    """Reads channel and data of a datagram; None if it begins no message.

    Args:
        datagram: What came by UDP.
    """
    if datagram[:4] == _SHORT:
        rest = datagram[_SHORT_HEADER.size :]
    elif (
        datagram[:4] == _FRAGMENT
        and len(datagram) >= _FRAGMENT_HEADER.size
        and _FRAGMENT_HEADER.unpack_from(datagram)[4] == 0
    ):
        rest = datagram[_FRAGMENT_HEADER.size :]
    else:
        return None
    channel, end, data = rest.partition(b"\0")
    if not end:
        return None
    return channel.decode("utf-8", "replace"), data


class Eavesdropper:
    """A socket on the multicast group of a wire; it sends nothing."""

    def __init__(self, url: str):
        """Joins the group.

        Args:
            url: LCM URL, `udpm://ADDRESS:PORT?ttl=N`.

        Raises:
            RemoSplatError: The group cannot be joined.
        """
        match = re.match(r"udpm://([\d.]+):(\d+)", url)
        if match is None:
            raise RemoSplatError(f"LCM URL {url!r}: no packets to hear")
        self.group, self.port = match[1], int(match[2])
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            for option in (socket.SO_REUSEADDR, socket.SO_REUSEPORT):
                self._socket.setsockopt(socket.SOL_SOCKET, option, 1)
            self._socket.bind((self.group, self.port))
            membership = socket.inet_aton(self.group) + socket.inet_aton(
                "0.0.0.0"
            )
            self._socket.setsockopt(
                socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, membership
            )
        except OSError as error:
            self._socket.close()
            raise RemoSplatError(
                f"LCM URL {url!r}: {error.strerror or error}"
            ) from error

    def __enter__(self) -> "Eavesdropper":
        return self

    def __exit__(self, *_: object) -> None:
        self._socket.close()

    def listen(self, duration: float) -> Iterator[Packet]:
        """Yields the packets that come for some time.

        Args:
            duration: How long to listen [s].
        """
        end = time.monotonic() + duration
        while (left := end - time.monotonic()) > 0:
            if not select.select([self._socket], [], [], left)[0]:
                return
            datagram, sender = self._socket.recvfrom(_LARGEST)
            parsed = parse_packet(datagram)
            if parsed is not None:
                yield Packet(sender, *parsed, time.time())
