"""`MappingProcess`: the control process's end of the mapping process."""

import logging
import multiprocessing
import os
import select
import signal
import weakref
from collections import deque
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from threading import Thread
from time import monotonic, sleep

from remosplat_drake.base.one_thread import one_thread_environment
from remosplat_drake.mapping.mapping_job import MappingJob
from remosplat_drake.mapping.messages import (
    Event,
    Idle,
    Request,
    ShowScene,
    Trouble,
)
from remosplat_drake.mapping.worker import serve

DIED = "the mapping process has died; the next request starts it again"
BUSY = "the mapping process is busy: a request was dropped"

MOST_UNANSWERED = 100
"""Greatest number of unanswered requests: more could fill the pipe, and the
sender would have to wait."""

PATIENCE = 600.0
"""Longest time that `wait` waits [s]."""

_log = logging.getLogger(__name__)


class MappingProcess:
    """Takes pictures and makes maps in a process of lowest priority (nice 19).

    Nothing waits for the process, neither for its start nor for its answers.
    All that it knows is in its session's folder: when it dies, `poll` tells
    so once, and the next request starts another one, which goes on there.

    Attributes:
        sent: Number of requests so far.
        answered: Number of requests that are dealt with, or lost.
    """

    def __init__(self, job: MappingJob):
        """Starts the process.

        Args:
            job: All that the process needs.
        """
        self._job = job
        self.sent = self.answered = 0
        self._answered_before = 0
        self._scene: ShowScene | None = None
        self._outbox: deque[Request] = deque()
        self._own_events: deque[Event] = deque()
        self._link = _Link()
        self.close = weakref.finalize(self, _Link.end, self._link)
        self._restart()

    @property
    def process(self) -> BaseProcess | None:
        """The process; None while none is running, or one is being started."""
        return self._link.process

    def request(self, request: Request) -> None:
        """Sends a request; where the process has died a new one is started."""
        if self.sent - self.answered >= MOST_UNANSWERED:
            self._own_events.append(Trouble(BUSY))
            return
        self.sent += 1
        self._outbox.append(request)
        if self._link.is_down:
            self._restart()
        if isinstance(request, ShowScene):
            self._scene = request

    def poll(self) -> list[Event]:
        """Returns what the process has told since the last call, at once."""
        events: list[Event] = []
        while event := self._next_event():
            events.append(event)
        return events

    def wait(self, count: int) -> list[Event]:
        """Waits until requests are answered, ten minutes at most.

        Args:
            count: Number of requests that must be answered, of all that
                were ever sent.

        Returns:
            What the process has told by then.
        """
        events: list[Event] = []
        end = monotonic() + PATIENCE
        while self.answered < count and monotonic() < end:
            if event := self._next_event():
                events.append(event)
            else:
                self._link.wait(0.05)
        return events

    def _next_event(self) -> Event | None:
        if self._own_events:
            event = self._own_events.popleft()
        elif self._link.connection is None:
            return None
        else:
            try:
                while self._outbox:
                    self._link.connection.send(self._outbox[0])
                    self._outbox.popleft()
                if not self._link.has_news():
                    return None
                event = self._link.connection.recv()
            except (EOFError, OSError):
                return self._lost()
        if isinstance(event, Idle):
            self.answered = self._answered_before + event.answered
        return event

    def _lost(self) -> Event:
        """Gives the process up, and with it all that it was asked for."""
        _log.warning(DIED)
        self._link.end(patience=0.0)
        self._outbox.clear()
        self._answered_before = 0
        self._own_events.append(Idle(self.sent))
        return Trouble(DIED)

    def _restart(self) -> None:
        """Starts a process that knows the session's folder and the scene."""
        if self._scene is not None:
            self._outbox.appendleft(self._scene)
        self._answered_before = self.sent - len(self._outbox)
        self._link.start(self._job)


class _Link:
    """A process, and the pipe to it."""

    def __init__(self):
        self.connection: Connection | None = None
        self.process: BaseProcess | None = None
        self._poll = select.poll()
        self._starter: Thread | None = None

    @property
    def is_down(self) -> bool:
        """Whether there is no process, and none is being started."""
        return self._starter is None

    def start(self, job: MappingJob) -> None:
        """Starts a process in a thread, for spawning takes a while."""
        self._starter = Thread(target=self._spawn, args=(job,))
        self._starter.start()

    def _spawn(self, job: MappingJob) -> None:
        # The process inherits both: Ctrl-C does not reach even its start, and
        # it has no real-time priority (SCHED_RR) where the control loop has.
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
        spawn = multiprocessing.get_context("spawn")
        connection, theirs = spawn.Pipe()
        process = spawn.Process(
            target=serve, args=(theirs, job), name="mapping", daemon=True
        )
        try:
            with one_thread_environment():
                process.start()
            self.process = process
        finally:
            # Without a process the first look finds the other end closed.
            theirs.close()
            self._poll.register(connection.fileno(), select.POLLIN)
            self.connection = connection

    def has_news(self) -> bool:
        """Whether an event, or the end of the pipe, can be read."""
        return bool(self._poll.poll(0))

    def wait(self, timeout: float) -> None:
        """Waits for news [s]."""
        if self.connection is None:
            sleep(timeout)
        else:
            self._poll.poll(1e3 * timeout)

    def end(self, patience: float = 2.0) -> None:
        """Ends the process: it leaves when nobody is at the other end.

        Args:
            patience: After which it is killed [s].
        """
        if self._starter is not None:
            self._starter.join()
            self._starter = None
        if self.connection is not None:
            self._poll.unregister(self.connection.fileno())
            self.connection.close()
            self.connection = None
        if self.process is not None:
            self.process.join(patience)
            if self.process.is_alive():
                self.process.kill()
                self.process.join()
            self.process = None
