"""Tools for real-time loops: SCHED_RR, garbage collection, statistics."""

import contextlib
import dataclasses as dc
import gc
import math
import os
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

CONTROLLER_PRIORITY = 5
"""SCHED_RR priority of the process that runs the controller."""

DRIVER_PRIORITY = 10
"""SCHED_RR priority of the robot's drivers. It is higher than the
controller's."""

KEPT = 60_000
"""Number of the latest ticks over which statistics are computed: those of ten
minutes at 100 Hz."""


@contextlib.contextmanager
def realtime_priority(priority: int) -> Iterator[None]:
    """Gives this process a SCHED_RR priority while the block runs.

    If the system does not allow this priority (see `ulimit -r`), nothing
    changes. The priority applies to all threads that exist when the block
    begins, such as those that receive LCM messages. Threads and processes that
    are started inside the block inherit the priority, except a `ChildProcess`.
    At the end of the block, the threads that existed at its beginning return to
    SCHED_OTHER.

    Args:
        priority: `CONTROLLER_PRIORITY` or `DRIVER_PRIORITY`. A thread with a
            higher priority preempts threads with lower priorities.
    """
    tasks = Path("/proc/self/task")
    threads = [int(task.name) for task in tasks.glob("*")]
    for thread in threads:
        with contextlib.suppress(OSError):
            parameters = os.sched_param(priority)
            os.sched_setscheduler(thread, os.SCHED_RR, parameters)
    try:
        yield
    finally:
        for thread in threads:
            with contextlib.suppress(OSError):
                os.sched_setscheduler(thread, os.SCHED_OTHER, os.sched_param(0))


@contextlib.contextmanager
def garbage_collection_disabled() -> Iterator[None]:
    """Disables Python's cyclic garbage collector while the block runs.

    A garbage collection would take longer than several ticks. At the start of
    the block, existing garbage is collected, and the remaining objects are
    frozen (`gc.freeze`).
    """
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
    """Median, 99th percentile and maximum of a quantity, in its own unit."""

    p50: float
    p99: float
    max: float

    @staticmethod
    def of(values: np.ndarray) -> "Spread":
        """Computes the spread of an array of shape (n,); NaN if n is 0."""
        if not len(values):
            return Spread(math.nan, math.nan, math.nan)
        p50, p99 = np.percentile(values, [50, 99])
        return Spread(float(p50), float(p99), float(values.max()))


@dc.dataclass(frozen=True)
class LoopQuality:
    """Timing statistics of a real-time loop.

    Attributes:
        period: The requested period [s].
        ticks: Number of ticks.
        missed: Number of ticks that were skipped because an earlier tick took
            too long.
        unheard: Number of ticks without a new status of the robot.
        age: Time from the stamp of the robot's status to the stamp of the
            command that was computed from this status [s].
        jitter: Absolute difference between the period and the time between two
            commands [s].
        work: Time from the arrival of the status to the sending of the command
            [s].
        busy: Processor time of the loop's thread from one command to the next
            [s]. Unlike `work`, it excludes time in which the thread waits.
        image_to_command: Time from the stamp of a depth image in which moving
            objects are detected to the stamp of the first command that was
            computed with the detected objects [s]; None if there are no such
            images.
    """

    period: float
    ticks: int
    missed: int
    unheard: int
    age: Spread
    jitter: Spread
    work: Spread
    busy: Spread
    image_to_command: Spread | None = None


class LoopLog:
    """Records the ticks of a real-time loop; `LoopQuality` summarises them.

    The statistics of a long run include only its latest `KEPT` ticks.

    Attributes:
        missed: Number of skipped ticks; the loop increments it.
        unheard: Number of ticks without a new status; the loop increments it.
    """

    def __init__(self, period: float):
        """Makes an empty log.

        Args:
            period: Time between two ticks [s].
        """
        self._period = period
        # The rows are a ring buffer, since a run may last for hours, and its
        # memory must not grow. The columns are age, work, time of sending,
        # processor time, and the stamp of the image.
        self._rows = np.full((KEPT, 5), math.nan)
        self._ticks = 0
        self.missed = 0
        self.unheard = 0

    @property
    def age(self) -> float:
        """Time from status to command in the latest tick [s]; NaN if none."""
        return float(self._rows[(self._ticks - 1) % KEPT, 0])

    def record(
        self,
        *,
        stamp: float,
        heard: float,
        sent: float,
        image: float = math.nan,
    ) -> None:
        """Records one tick; must be called on the loop's own thread.

        Args:
            stamp: Stamp of the robot's status, by the sender's wall clock [s].
            heard: Time of the status's arrival, by the local wall clock [s].
            sent: Stamp of the command, by the local wall clock [s].
            image: Stamp of the newest depth image in which moving objects were
                detected, by the wall clock [s]; NaN if there are no such
                images.
        """
        row = (sent - stamp, sent - heard, sent, time.thread_time(), image)
        self._rows[self._ticks % KEPT] = row
        self._ticks += 1

    def quality(self) -> LoopQuality:
        """Returns the statistics of the latest ticks."""
        oldest = max(0, self._ticks - KEPT)
        order = np.arange(oldest, self._ticks) % KEPT
        age, work, sent, processor, image = self._rows[order].T
        is_new = np.isfinite(image[1:]) & (image[1:] != image[:-1])
        return LoopQuality(
            period=self._period,
            ticks=self._ticks,
            missed=self.missed,
            unheard=self.unheard,
            age=Spread.of(age),
            jitter=Spread.of(np.abs(np.diff(sent) - self._period)),
            work=Spread.of(work),
            busy=Spread.of(np.diff(processor)),
            image_to_command=Spread.of((sent - image)[1:][is_new])
            if is_new.any()
            else None,
        )
