"""`CockpitProcess`: starts the cockpit's process and exchanges messages."""

import logging
import weakref
from collections.abc import Callable
from multiprocessing.connection import Connection
from threading import Condition, Thread
from time import monotonic

from remosplat_drake.base.array_pipe import send_arrays
from remosplat_drake.base.child_process import ChildProcess
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.cockpit.messages import (
    Beat,
    CockpitJob,
    CockpitRequests,
    CodeIssued,
    Failed,
    MapPicture,
    PageContent,
    Serving,
)

START_TIME = 120.0
"""The page must be served within this time after the start of the process
[s]."""

PATIENCE = 3.0
"""STOP counts as broken if the process has sent no message for this time
[s]."""

DIED = (
    "the cockpit's process has ended, so its STOP does not work: stop the "
    "robot by its own stop button"
)
SILENT = (
    f"the cockpit has not answered for {PATIENCE:g} s, so its STOP does not "
    "work: stop the robot by its own stop button"
)

_NICENESS = 0
"""Nice value of the process. It is 0, the normal priority, since STOP must also
work on a busy computer."""

_log = logging.getLogger(__name__)


class CockpitProcess:
    """Serves the cockpit's page in a separate process.

    Only `start` waits for that process, until the page can be opened. One
    thread sends the page's content; if new content arrives faster than it is
    sent, the thread skips older content. Another thread reads requests.

    Attributes:
        requests: All requests so far.
    """

    def __init__(self, announce: Callable[[CodeIssued], None]):
        """Prepares a process, which `start` starts.

        Args:
            announce: Function that is called, in a thread, with each new code
                that lets a client operate.
        """
        self.requests = CockpitRequests()
        self._announce = announce
        self._child = ChildProcess(_serve, "cockpit", _NICENESS)
        self._news = Condition()
        self._content: PageContent | None = None
        self._picture: MapPicture | None = None
        self._heard_at = float("inf")
        self._is_dead = False
        self.close = weakref.finalize(self, ChildProcess.end, self._child)

    def start(self, job: CockpitJob, picture: MapPicture) -> str:
        """Starts the process and waits until its page can be opened.

        Args:
            job: The settings of the cockpit.
            picture: The map at the start.

        Returns:
            The address of the page.

        Raises:
            RemoSplatError: The page cannot be served.
        """
        self._child.start(job, picture)
        connection, self.process = self._child.wait_until_started()
        try:
            ready = connection.poll(START_TIME)
            message = connection.recv() if ready else Failed("no answer")
        except (EOFError, OSError):
            message = Failed("its process has died")
        if not isinstance(message, Serving):
            self.close()
            reason = message.reason if isinstance(message, Failed) else message
            raise RemoSplatError(f"the cockpit cannot be served: {reason}")
        self._connection = connection
        self._heard_at = monotonic()
        for work in (self._send, self._listen):
            Thread(target=work, daemon=True).start()
        return message.url

    def show(self, content: PageContent) -> None:
        """Queues the page's content; replaces content that is not sent yet.

        The newer content includes the worst control tick of the replaced
        content.

        Args:
            content: The page's content at that moment.
        """
        with self._news:
            self._content = content.after(self._content)
            self._news.notify()

    def show_map(self, picture: MapPicture) -> None:
        """Shows another version of the map.

        Args:
            picture: The map.
        """
        with self._news:
            self._picture = picture
            self._news.notify()

    @property
    def trouble(self) -> str:
        """Reason why the page's STOP does not work; empty while it works."""
        if self._is_dead:
            return DIED
        return SILENT if self.silence > PATIENCE else ""

    @property
    def silence(self) -> float:
        """Time since the process's last message [s]."""
        return monotonic() - self._heard_at

    def _send(self) -> None:
        """Sends the newest content and map, in a separate thread."""
        try:
            while True:
                with self._news:
                    while self._content is None and self._picture is None:
                        self._news.wait()
                    content, self._content = self._content, None
                    picture, self._picture = self._picture, None
                if picture is not None:
                    send_arrays(self._connection, picture)
                if content is not None:
                    self._connection.send(content)
        except OSError:
            self._is_dead = True

    def _listen(self) -> None:
        """Receives requests, in a separate thread."""
        try:
            while True:
                message = self._connection.recv()
                self._heard_at = monotonic()
                if isinstance(message, CockpitRequests):
                    self.requests = message
                elif isinstance(message, CodeIssued):
                    self._announce(message)
                else:
                    assert isinstance(message, Beat)
        except (EOFError, OSError, TypeError):
            # A TypeError means that the pipe was closed while it was read.
            self._is_dead = True


def _serve(
    connection: Connection, job: CockpitJob, picture: MapPicture
) -> None:
    """Runs in the cockpit's process, the only process that imports viser."""
    from remosplat_drake.cockpit.server import serve

    serve(connection, job, picture)
