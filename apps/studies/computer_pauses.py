"""`ComputerPauses`: records pauses in which a computer runs no process.

A virtual machine pauses if its host needs the processors, also for processes
with real-time priority. A process that sleeps for short times notices such a
pause, because it wakes up late.
"""

import multiprocessing
import time
from multiprocessing.connection import Connection
from typing import NamedTuple

_SLEEP = 0.005
"""Time between two wake-ups of the watching process [s]."""

_LATE = 0.01
"""Times between two wake-ups above this are reported as pauses [s]."""


class Pause(NamedTuple):
    """A time in which the watching process did not run.

    Attributes:
        start: Beginning, by `time.monotonic` [s].
        end: End, by the same clock [s].
    """

    start: float
    end: float


class ComputerPauses:
    """Records the pauses of this computer in a process of its own.

    The process inherits its priority from the process that starts it.
    """

    def __init__(self) -> None:
        context = multiprocessing.get_context("spawn")
        self._reports, child = context.Pipe(duplex=False)
        self._process = context.Process(
            target=_watch, args=(child,), name="pauses", daemon=True
        )
        self._process.start()
        child.close()
        self._pauses: list[Pause] = []

    @property
    def pid(self) -> int | None:
        """The watching process."""
        return self._process.pid

    def longest(self, since: float, until: float) -> float:
        """Returns the length of the longest pause that touches a time [s].

        Args:
            since: Beginning of this time, by `time.monotonic` [s].
            until: Its end [s].
        """
        while self._reports.poll():
            self._pauses.append(self._reports.recv())
        return longest_pause(self._pauses, since, until)

    def close(self) -> None:
        """Ends the watching process."""
        self._reports.close()
        self._process.terminate()
        self._process.join()


def longest_pause(pauses: list[Pause], since: float, until: float) -> float:
    """Returns the length of the longest pause that touches a time [s].

    Args:
        pauses: The pauses.
        since: Beginning of this time [s].
        until: Its end [s].
    """
    return max(
        (
            pause.end - pause.start
            for pause in pauses
            if pause.end >= since and pause.start <= until
        ),
        default=0.0,
    )


def _watch(reports: Connection) -> None:
    """Reports each `Pause`, until the reader closes its end."""
    before = time.monotonic()
    while True:
        time.sleep(_SLEEP)
        now = time.monotonic()
        if now - before > _LATE:
            try:
                reports.send(Pause(before, now))
            except ConnectionError:
                return
        before = now
