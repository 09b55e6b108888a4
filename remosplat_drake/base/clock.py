"""The two clocks of a driver: one for stamps, one for its pace."""

import contextlib
import os
import time

MICROSECONDS = 1_000_000

_PRIORITY = 10


def wall_utime() -> int:
    """The wall clock, in microseconds of the Unix epoch."""
    return time.time_ns() // 1000


def go_first() -> None:
    """Asks for real-time scheduling, as libfranka does, where it is allowed.

    Threads that are started afterwards, those of LCM above all, have it too.
    """
    with contextlib.suppress(OSError):
        os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(_PRIORITY))


class Pacer:
    """Holds a loop to a fixed period, and remembers how well that went.

    A loop that is late runs without a pause until it has caught up. After a
    stall of more than `patience` the backlog is forgotten: a burst of old
    ticks would help nobody.
    """

    def __init__(self, period: float, patience: float = 0.02):
        """Starts at the first call of `wait`.

        Args:
            period: Time between two ticks [s].
            patience: Longest backlog that is worked off [s].
        """
        self._period = period
        self._patience = patience
        self._start = self._due = 0.0
        self.ticks = 0
        self.missed = 0
        self.worst = 0.0

    def wait(self) -> None:
        """Sleeps until the next tick is due."""
        now = time.monotonic()
        if not self.ticks:
            self._start = self._due = now
        else:
            self._due += self._period
        self.ticks += 1
        late = now - self._due
        if late < 0:
            time.sleep(-late)
            return
        self.worst = max(self.worst, late)
        if late > self._patience:
            self.missed += round(late / self._period)
            self._due = now

    @property
    def rate(self) -> float:
        """Ticks a second since the start [Hz]."""
        elapsed = time.monotonic() - self._start
        return (self.ticks - 1) / elapsed if self.ticks > 1 else 0.0
