"""Time: wall-clock stamps, numbers of ticks, stopwatches, fixed-rate loops."""

import math
import time

MICROSECONDS = 1_000_000
"""Microseconds in a second; message stamps are in microseconds."""

LATEST_START = 0.5
"""A tick is started only if its delay is at most this fraction of the
period."""


def wall_utime() -> int:
    """Returns the wall-clock time in microseconds since the Unix epoch."""
    return time.time_ns() // 1000


def next_tick(now: float, period: float, latest: int) -> int:
    """Returns the number of the next tick that can still start in time.

    Tick n is due at the time n * period after the Unix epoch, in the same way
    as Drake's periodic events are due at multiples of their period. A tick is
    skipped if it would start more than `LATEST_START` * period after the time
    at which it is due.

    Args:
        now: Wall-clock time since the Unix epoch [s].
        period: Time between two ticks [s].
        latest: Number of the latest tick that was started. The returned number
            is higher, even if the clock was set back.
    """
    return max(latest + 1, math.ceil(now / period - LATEST_START))


def sleep_until(wake: float, longest: float) -> None:
    """Sleeps until a time of the wall clock, but no longer than `longest`.

    Args:
        wake: Time at which to return, since the Unix epoch [s].
        longest: The sleep takes at most this time [s], even if the clock is
            wrong or was set back.
    """
    duration = min(wake - time.time(), longest)
    if duration > 0:
        time.sleep(duration)


class Laps:
    """A stopwatch that measures the durations of consecutive parts of a job.

    Attributes:
        seconds: Duration of each part that has ended, keyed by name [s].
    """

    def __init__(self):
        self.seconds: dict[str, float] = {}
        self._start = time.perf_counter()

    def end(self, name: str) -> None:
        """Ends the current part, and begins the next one.

        Args:
            name: Name of the part that ends.
        """
        now = time.perf_counter()
        self.seconds[name] = now - self._start
        self._start = now


class Pacer:
    """Runs the loop of a robot's driver at a fixed period (monotonic clock).

    If the loop is late, it runs without pauses until it has caught up. If it is
    late by more than `patience`, the missed ticks are dropped, since a burst of
    outdated ticks has no use.

    Attributes:
        ticks: Number of calls of `wait`.
        missed: Number of ticks that were dropped after stalls.
        late: The delay of the latest tick [s]. It includes the time by which
            the sleep before the tick was too long.
        worst: The largest delay of a tick so far [s].
    """

    def __init__(self, period: float, patience: float = 0.02):
        """Prepares the loop; its first tick is due at the first call of `wait`.

        Args:
            period: Time between two ticks [s].
            patience: Ticks are dropped only if the delay exceeds this time [s].
        """
        self._period = period
        self._patience = patience
        self._start = self._due = 0.0
        self.ticks = 0
        self.missed = 0
        self.late = 0.0
        self.worst = 0.0

    def wait(self) -> None:
        """Sleeps until the next tick is due."""
        now = time.monotonic()
        if not self.ticks:
            self._start = self._due = now
        else:
            self._due += self._period
        self.ticks += 1
        if now < self._due:
            time.sleep(self._due - now)
            now = time.monotonic()
        self.late = max(0.0, now - self._due)
        self.worst = max(self.worst, self.late)
        if self.late > self._patience:
            self.missed += round(self.late / self._period)
            self._due, self.late = now, 0.0

    @property
    def rate(self) -> float:
        """Mean rate of the ticks since the first one [Hz]."""
        elapsed = time.monotonic() - self._start
        return (self.ticks - 1) / elapsed if self.ticks > 1 else 0.0
