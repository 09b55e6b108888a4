"""`MappingProcess`: starts the mapping process, and sends it requests."""

import logging
import weakref
from collections import deque
from multiprocessing.process import BaseProcess
from time import monotonic

from remosplat_drake.base.child_process import ChildProcess
from remosplat_drake.mapping.mapping_job import MappingJob
from remosplat_drake.mapping.messages import (
    Event,
    Idle,
    Located,
    Request,
    ShowScene,
    Track,
    Trouble,
)
from remosplat_drake.mapping.worker import serve

DIED = "the mapping process has died; the next request starts it again"
BUSY = "the mapping process is busy: a request was dropped; repeat it later"

MOST_UNANSWERED = 100
"""At most this many requests may be unanswered. More requests could fill the
pipe, and the sender would then have to wait.
"""

PATIENCE = 600.0
"""`wait` waits for at most this time [s]."""

_NICENESS = 5
"""Niceness of the process. Control has priority, and if two cores are busy, the
process still gets a quarter of a core.
"""

_log = logging.getLogger(__name__)


class MappingProcess:
    """A process with lower priority (nice 5) that builds maps from pictures.

    The control process waits neither for the start of this process nor for its
    answers. The state of the process is in the session's folder. If the process
    dies, `poll` reports this once. The next request then starts a new process,
    which continues with this folder.

    Attributes:
        sent: Number of requests so far.
        answered: Number of requests that were answered or lost.
    """

    def __init__(self, job: MappingJob):
        """Starts the process.

        Args:
            job: All inputs of the process.
        """
        self._job = job
        self.sent = self.answered = 0
        self._answered_before = 0
        self._is_tracking = False
        self._scene: ShowScene | None = None
        self._outbox: deque[Request] = deque()
        self._own_events: deque[Event] = deque()
        # With a fixed latency, the control process waits for this process, so
        # niceness would delay it.
        niceness = _NICENESS if job.config.latency is None else 0
        self._child = ChildProcess(serve, "mapping", niceness)
        self.close = weakref.finalize(self, ChildProcess.end, self._child)
        self._restart()

    @property
    def process(self) -> BaseProcess | None:
        """The process; None before it has started, or after it has died."""
        return self._child.process

    def request(self, request: Request) -> None:
        """Sends a request; if the process has died, a new one is started."""
        if self.sent - self.answered >= MOST_UNANSWERED:
            self._own_events.append(Trouble(BUSY))
            return
        self.sent += 1
        self._outbox.append(request)
        if self._child.is_down:
            self._restart()
        if isinstance(request, ShowScene):
            self._scene = request

    def track(self, request: Track) -> None:
        """Requests a localisation of the base, if the previous one is done.

        `wait` does not wait for this request. If the process has died, the
        request does not start a new one.
        """
        if not self._is_tracking and not self._child.is_down:
            self._is_tracking = True
            self._outbox.append(request)

    def poll(self) -> list[Event]:
        """Returns the events since the last call, without waiting."""
        events: list[Event] = []
        while event := self._next_event():
            events.append(event)
        return events

    def wait(self, count: int) -> list[Event]:
        """Waits until requests are answered, for at most ten minutes.

        Args:
            count: Number of requests since the start that must be answered.

        Returns:
            The events so far.
        """
        events: list[Event] = []
        end = monotonic() + PATIENCE
        while self.answered < count and monotonic() < end:
            if event := self._next_event():
                events.append(event)
            else:
                self._child.wait(0.05)
        return events

    def _next_event(self) -> Event | None:
        if self._own_events:
            event = self._own_events.popleft()
        elif self._child.connection is None:
            return None
        else:
            try:
                while self._outbox:
                    self._child.connection.send(self._outbox[0])
                    self._outbox.popleft()
                if not self._child.has_news():
                    return None
                event = self._child.connection.recv()
            except (EOFError, OSError):
                return self._lost()
        if isinstance(event, Located):
            self._is_tracking = False
        if isinstance(event, Idle):
            self.answered = self._answered_before + event.answered
        return event

    def _lost(self) -> Event:
        """Drops the process, and counts all its requests as answered."""
        _log.warning(DIED)
        self._child.end(patience=0.0)
        self._outbox.clear()
        self._answered_before = 0
        self._own_events.append(Idle(self.sent))
        return Trouble(DIED)

    def _restart(self) -> None:
        """Starts a process with the session's folder and the scene."""
        if self._scene is not None:
            self._outbox.appendleft(self._scene)
        self._answered_before = self.sent - len(self._outbox)
        self._is_tracking = False
        self._child.start(self._job)
