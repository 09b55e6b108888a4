"""`ComputerPauses`: records pauses in which a core runs no process.

The cores of a virtual machine pause if the host needs them, also for processes
with real-time priority. A process that sleeps for short times notices a pause
of its core, because it wakes up late.
"""

import multiprocessing
import os
import time
from multiprocessing.connection import Connection
from typing import NamedTuple

_SLEEP = 0.005
"""Time between two wake-ups of the watching process [s]."""

_LATE = 0.01
"""Times between two wake-ups above this are reported as pauses [s]."""


class Pause(NamedTuple):
    """A time in which a watching process did not run.

    Attributes:
        start: Beginning, by `time.monotonic` [s].
        end: End, by the same clock [s].
    """

    start: float
    end: float


class ComputerPauses:
    """Records the pauses of each core of this computer, in a process on it.

    The processes inherit the priority of the process that starts them.

    Attributes:
        processes: The watching processes.
    """

    def __init__(self) -> None:
        context = multiprocessing.get_context("spawn")
        self.processes, self._reports = [], []
        for core in os.sched_getaffinity(0):
            reports, child = context.Pipe(duplex=False)
            process = context.Process(
                target=_watch, args=(child, core), daemon=True
            )
            process.start()
            child.close()
            self.processes.append(process)
            self._reports.append(reports)
        self._pauses: list[Pause] = []

    def longest(self, since: float, until: float) -> float:
        """Returns the length of the longest pause that touches a time [s].

        Args:
            since: Beginning of this time, by `time.monotonic` [s].
            until: Its end [s].
        """
        for reports in self._reports:
            while reports.poll():
                self._pauses.append(reports.recv())
        return longest_pause(self._pauses, since, until)

    def close(self) -> None:
        """Ends the watching processes."""
        for process, reports in zip(self.processes, self._reports, strict=True):
            reports.close()
            process.terminate()
            process.join()


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


def _watch(reports: Connection, core: int) -> None:
    """Reports each `Pause` of a core, until the reader closes its end."""
    os.sched_setaffinity(0, {core})
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
