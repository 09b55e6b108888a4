"""Ticks by the wall clock, and how well they were kept."""

import contextlib
import dataclasses as dc
import gc
import math
import os
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

LATEST_START = 0.5
"""A tick starts so late at most, as a share of the period."""

KEPT = 60_000
"""Spreads are over so many ticks at most, the latest ones: ten minutes at
100 Hz."""

_PRIORITY = 5  # The drivers have 10.


def next_tick(now: float, period: float, latest: int) -> int:
    """Number of the next tick; those that cannot start in time are left out.

    Tick n is at n * period, counted from the Unix epoch as Drake counts its
    periodic events from 0.

    Args:
        now: Wall clock [s].
        period: Time between two ticks [s].
        latest: Number of the latest tick.
    """
    return max(latest + 1, math.ceil(now / period - LATEST_START))


def sleep_until(wake: float, longest: float) -> None:
    """Sleeps until a time of the wall clock, even if that is set back.

    Args:
        wake: When to return [s].
        longest: No sleep is longer [s].
    """
    duration = min(wake - time.time(), longest)
    if duration > 0:
        time.sleep(duration)


@contextlib.contextmanager
def going_first() -> Iterator[None]:
    """Real-time scheduling for our threads, where the system allows it.

    Those that receive messages have it, too. Processes that were started
    before, such as the one that looks ahead, have it not; and the drivers go
    before us.
    """
    tasks = Path("/proc/self/task")
    threads = [int(task.name) for task in tasks.glob("*")]
    for thread in threads:
        with contextlib.suppress(OSError):
            priority = os.sched_param(_PRIORITY)
            os.sched_setscheduler(thread, os.SCHED_RR, priority)
    try:
        yield
    finally:
        for thread in threads:
            with contextlib.suppress(OSError):
                os.sched_setscheduler(thread, os.SCHED_OTHER, os.sched_param(0))


@contextlib.contextmanager
def garbage_kept() -> Iterator[None]:
    """Keeps Python from collecting garbage in the middle of a tick."""
    gc.collect()
    gc.freeze()
    gc.disable()
    try:
        yield
    finally:
        gc.enable()
        gc.unfreeze()


@dc.dataclass(frozen=True)
class Spread:
    """How a quantity is spread, in its own unit."""

    p50: float
    p99: float
    max: float

    @staticmethod
    def of(values: np.ndarray) -> "Spread":
        """The spread of some values; NaN without any."""
        if not len(values):
            return Spread(math.nan, math.nan, math.nan)
        p50, p99 = np.percentile(values, [50, 99])
        return Spread(float(p50), float(p99), float(values.max()))


@dc.dataclass(frozen=True)
class LoopQuality:
    """How a real-time loop ran.

    Attributes:
        period: That was asked for [s].
        ticks: How many there were.
        missed: Ticks that were left out because one before took too long.
        unheard: Ticks for which the robot sent no new status in time.
        age: From the stamp of the status that a command rests on to that of
            the command [s].
        jitter: Difference of the time between two commands and the period,
            without its sign [s].
        work: From the status to the command [s].
        busy: Processor time of the loop's thread from one command to the
            next; unlike `work` it counts no waiting [s].
    """

    period: float
    ticks: int
    missed: int
    unheard: int
    age: Spread
    jitter: Spread
    work: Spread
    busy: Spread


class LoopLog:
    """Collects what `LoopQuality` sums up; in long runs, of the latest ticks.

    Attributes:
        missed: See `LoopQuality`.
        unheard: See `LoopQuality`.
    """

    def __init__(self, period: float):
        """Starts empty.

        Args:
            period: Time between two ticks [s].
        """
        self._period = period
        # Age, work, time of sending and of the processor, in turns: a run
        # may last for hours, and its memory must not grow.
        self._rows = np.full((KEPT, 4), math.nan)
        self._ticks = 0
        self.missed = 0
        self.unheard = 0

    @property
    def age(self) -> float:
        """From status to command at the latest tick [s]; NaN before."""
        return float(self._rows[(self._ticks - 1) % KEPT, 0])

    def record(self, *, stamp: float, heard: float, sent: float) -> None:
        """Notes one tick, on the loop's own thread.

        Args:
            stamp: Of the status, by the sender's wall clock [s].
            heard: When the status was there, by our wall clock [s].
            sent: Stamp of the command [s].
        """
        row = (sent - stamp, sent - heard, sent, time.thread_time())
        self._rows[self._ticks % KEPT] = row
        self._ticks += 1

    def quality(self) -> LoopQuality:
        """Sums up the ticks so far."""
        oldest = max(0, self._ticks - KEPT)
        order = np.arange(oldest, self._ticks) % KEPT
        age, work, sent, processor = self._rows[order].T
        return LoopQuality(
            period=self._period,
            ticks=self._ticks,
            missed=self.missed,
            unheard=self.unheard,
            age=Spread.of(age),
            jitter=Spread.of(np.abs(np.diff(sent) - self._period)),
            work=Spread.of(work),
            busy=Spread.of(np.diff(processor)),
        )
