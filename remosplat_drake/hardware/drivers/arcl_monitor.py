"""`ArclMonitor`: reads the stops of an Omron base over the protocol ARCL."""

import contextlib
import re
import socket
import threading
import time
from collections.abc import Callable

from remosplat_drake.base.errors import FieldError
from remosplat_drake.hardware.drivers.arcl_text import (
    PROMPT,
    QUERY,
    STATUS,
    WELCOME,
    ArclState,
    with_line,
)
from remosplat_drake.hardware.drivers.base_stops import BaseStops

PORT = 7171
"""TCP port of ARCL, unless it is configured otherwise."""

EXPIRY = 0.5
"""An answer about the motors is ignored if it is older than this [s]."""

_PERIOD = 0.1
"""Time between two queries about the motors [s]."""

_STATUS_EVERY = 20
"""The state of charge is queried after this many queries about the motors."""

_LOGIN = 5.0
"""Longest wait for the password prompt, and for the reply to a password [s]."""

_SILENCE = 2.0
"""The connection counts as lost after this time without an answer [s]."""

_PAUSE = 1.0
"""Time between two attempts to connect [s]."""

_LONGEST_LINE = 4096
"""A line with more bytes than this is invalid, and is ignored."""


class ArclMonitor:
    """A `StopSource` that reads the stops of an Omron base in a thread.

    It logs in, queries the state of the motors ten times a second, and
    reconnects if the connection is lost. Without a recent answer, the base's
    state is unknown.
    """

    def __init__(
        self,
        host: str,
        port: int,
        password: str,
        say: Callable[[str], None] = lambda text: None,
    ):
        """Starts to connect, without waiting for the connection.

        Args:
            host: Name or address of the robot.
            port: TCP port of ARCL.
            password: The password of ARCL's server.
            say: Function that prints the reason why there is no connection. It
                is called once for each new reason.
        """
        self._address, self._password, self._say = (host, port), password, say
        self._state = ArclState()
        self._problem = ""
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def stops(self, t: float) -> BaseStops:
        """Returns the base's stops, which expire without a new answer."""
        return self._state.stops_at(t, EXPIRY)

    def close(self) -> None:
        """Disconnects."""
        self._ended.set()
        self._thread.join()

    def _run(self) -> None:
        while not self._ended.is_set():
            try:
                with socket.create_connection(self._address, _LOGIN) as link:
                    self._talk(link)
            except OSError as error:
                self._complain(str(error) or type(error).__name__)
            self._ended.wait(_PAUSE)

    def _complain(self, problem: str) -> None:
        if problem != self._problem:
            self._problem = problem
            self._say(f"ARCL {self._address[0]}:{self._address[1]}: {problem}")

    def _talk(self, link: socket.socket) -> None:
        """Logs in, and sends queries until the connection ends.

        Raises:
            OSError: The robot does not answer, has closed the connection, or
                rejects the password.
        """
        lines = _Lines(link)
        lines.wait_for(PROMPT, _LOGIN)
        link.sendall(self._password.encode() + b"\r\n")
        try:
            lines.wait_for(WELCOME, _LOGIN)
        except OSError as error:
            raise OSError(f"no welcome after the password: {error}") from error
        self._complain("")
        due, count, heard = 0.0, 0, time.monotonic()
        while not self._ended.is_set():
            now = time.monotonic()
            if now >= due:
                due = now + _PERIOD
                link.sendall(f"{QUERY}\r\n".encode())
                if count % _STATUS_EVERY == 0:
                    link.sendall(f"{STATUS}\r\n".encode())
                count += 1
            for line in lines.read(_PERIOD / 4):
                heard = time.monotonic()
                self._state = with_line(self._state, line, heard)
            if time.monotonic() - heard > _SILENCE:
                raise OSError(f"silent for {_SILENCE:g} s")


class _Lines:
    """Splits the bytes of a socket into lines."""

    def __init__(self, link: socket.socket):
        self._link = link
        self._rest = b""

    def read(self, timeout: float) -> list[str]:
        """Waits up to `timeout` [s] for data, and returns complete lines."""
        self._link.settimeout(timeout)
        with contextlib.suppress(TimeoutError):
            data = self._link.recv(_LONGEST_LINE)
            if not data:
                raise OSError("the robot has closed the connection")
            self._rest += data
        *lines, self._rest = re.split(rb"[\r\n]+", self._rest)
        self._rest = self._rest[-_LONGEST_LINE:]
        return [line.decode("ascii", "replace") for line in lines]

    def wait_for(self, text: str, limit: float) -> None:
        """Reads until a text has come; ignores upper and lower case.

        The text may be in an incomplete line, such as a prompt.

        Raises:
            OSError: The text does not come within `limit` [s].
        """
        end = time.monotonic() + limit
        while time.monotonic() < end:
            lines = [*self.read(0.1), self._rest.decode("ascii", "replace")]
            if any(text in line.lower() for line in lines):
                return
        raise OSError(f"did not send {text!r} within {limit:g} s")


def split_address(text: str) -> tuple[str, int]:
    """Splits HOST or HOST:PORT.

    Raises:
        FieldError: The port is not a number from 1 to 65535.
    """
    host, colon, port = text.partition(":")
    if not colon:
        return host, PORT
    if not (host and port.isdecimal() and 0 < int(port) < 2**16):
        raise FieldError("--arcl", text, "expected HOST or HOST:PORT")
    return host, int(port)
