"""Measures the cost of a live map for the control loop in real time."""

import dataclasses as dc
import gc
import time
from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np

from apps.studies.live_map.session import LiveSession
from remosplat_drake.app.scenario import Scenario
from remosplat_drake.app.scene_config import FREE, OBSTACLE
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.base.real_time import (
    CONTROLLER_PRIORITY,
    Spread,
    garbage_collection_disabled,
    realtime_priority,
)
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.controller.tick.run_tick import run_tick
from remosplat_drake.mapping.store.session import SESSION_FILE
from remosplat_drake.oracle.composite import CompositeDistanceField
from remosplat_drake.signals.map_requests import MapRequests

QUIET, QUICK, FULL = "nothing", "a quick map", "a full map"
"""Kinds of maps that may be under construction."""

_REQUESTS = {QUICK: MapRequests(frames=1), FULL: MapRequests(refines=1)}

_PATIENCE = 300.0
"""A map must be made within this time [s]."""


@dc.dataclass(frozen=True)
class TickTimes:
    """Timing of the ticks while one kind of map was under construction.

    Attributes:
        ticks: Number of ticks.
        late: Number of ticks that ended after the next one should have begun.
        period: Time from the end of one tick to that of the next [s].
        work: Time from the beginning of a tick to its end [s].
        busy: Processor time of a tick [s].
    """

    ticks: int
    late: int
    period: Spread
    work: Spread
    busy: Spread


@dc.dataclass(frozen=True)
class Swap:
    """Timing of a map that took effect.

    Attributes:
        effort: Kind of the map, `QUICK` or `FULL`.
        latency: Time from the entry in the session's file, just before the map
            is announced, to the end of the tick that changed to it [s].
        tick: Duration of this tick [s].
        next_tick: Duration of the following tick, which is the first to use
            only the new map [s].
    """

    effort: str
    latency: float
    tick: float
    next_tick: float


@dc.dataclass(frozen=True)
class LivePeriods:
    """Timing of a session in real time.

    Attributes:
        times: Timing of ticks by the kind of map under construction.
        swaps: Timing of every change of the map.
    """

    times: dict[str, TickTimes]
    swaps: list[Swap]


def measure_periods(
    session: LiveSession,
    folder: Path,
    *,
    rounds: int = 3,
    rest: float = 8.0,
    on_stage: Callable[[str], None] = lambda stage: None,
) -> LivePeriods:
    """Runs ticks in real time, alternately with and without map construction.

    The loop runs as with the real robot: it has a real-time priority (SCHED_RR)
    where the system allows that, and garbage collection is off within a tick.

    Args:
        session: New session, without a fixed latency.
        folder: Folder of the session.
        rounds: Number of quick maps and of full ones, each after a pause.
        rest: Time without a map under construction [s].
        on_stage: Callback for the name of each stage.

    Raises:
        RemoSplatError: A map is not made in time.
    """
    clock = _Clock(session, folder / SESSION_FILE)
    with realtime_priority(CONTROLLER_PRIORITY), garbage_collection_disabled():
        on_stage("scanning")
        for _ in first_map(session):
            clock.tick("")
        for effort in [QUICK, FULL] * rounds:
            on_stage(QUIET)
            end = session.time + rest
            while session.time < end:
                clock.tick(QUIET)
            on_stage(effort)
            session.ask(_REQUESTS[effort])
            for _ in until_changed(session):
                clock.tick(effort)
        clock.tick("")
    return clock.result()


def measure_unknown(
    session: LiveSession, scenario: Scenario
) -> dict[str, Spread]:
    """Measures ticks again, with unknown space as obstacle and as free.

    Each tick is computed in both ways, so that the load of the computer and the
    robot's states are the same.

    Args:
        session: Session with a map in which unknown space is an obstacle.
        scenario: Scenario of the session.

    Returns:
        Times of a tick [s], by how unknown space is treated.
    """
    field = session.status.scene_map.field
    assert isinstance(field, CompositeDistanceField)
    robot = session.robot
    law = ReactiveLaw.make(scenario.controller, robot, session.period)
    fields = {OBSTACLE: field, FREE: field.parts[0]}
    taken: dict[str, list[float]] = {name: [] for name in fields}
    for before, report in pairwise(session.reports):
        for name, asked in fields.items():
            start = time.perf_counter()
            spheres = robot.spheres_at(report.q)
            clearances = asked.clearances(spheres, law.collision.influence)
            run_tick(
                law,
                report.time,
                report.q,
                report.target,
                clearances,
                asked,
                before.command,
            )
            taken[name].append(time.perf_counter() - start)
    return {name: Spread.of(np.array(t)) for name, t in taken.items()}


def first_map(session: LiveSession) -> Iterator[None]:
    """Scans, and yields before each tick until there is a map."""
    session.scan()
    yield from until_changed(session)


def until_changed(session: LiveSession) -> Iterator[None]:
    """Yields before each tick until the map has changed.

    Raises:
        RemoSplatError: The map does not change in time.
    """
    before, end = session.status.swaps, session.time + _PATIENCE
    while session.status.swaps == before:
        if session.time > end:
            trouble = session.status.trouble or "the process is too slow"
            raise RemoSplatError(f"there is no new map: {trouble}")
        yield
    while session.status.is_building:
        yield


class _Clock:
    """Ticks a session at the wall clock's pace, and records the timing."""

    def __init__(self, session: LiveSession, session_file: Path):
        self._session = session
        self._file = session_file
        self._next = time.perf_counter()
        self._kinds: list[str] = []
        self._rows: list[tuple[float, float, float, bool]] = []
        self._swaps: list[tuple[int, float]] = []

    def tick(self, kind: str) -> None:
        """Waits for the next tick, and computes it.

        Args:
            kind: Kind of map under construction; empty for a tick that is not
                counted.
        """
        session = self._session
        self._next += session.period
        time.sleep(max(0.0, self._next - time.perf_counter()))
        if kind:
            session.move_on()
        swaps = session.status.swaps
        start, busy = time.perf_counter(), time.thread_time()
        session.tick()
        busy, end = time.thread_time() - busy, time.perf_counter()
        late = end > self._next + session.period
        if late:  # Lost ticks are not repeated.
            self._next = end - session.period
        if session.status.swaps != swaps:
            told = self._file.stat().st_mtime
            self._swaps.append((len(self._rows), time.time() - told))
        self._kinds.append(kind)
        self._rows.append((start, end, busy, late))
        gc.collect(1)

    def result(self) -> LivePeriods:
        """Returns the timing of all ticks so far."""
        start, end, busy, late = np.array(self._rows).T
        work, period = end - start, np.diff(end, prepend=np.nan)
        kinds = np.array(self._kinds)
        times = {}
        for kind in (QUIET, QUICK, FULL):
            rows = np.flatnonzero(kinds == kind)
            times[kind] = TickTimes(
                len(rows),
                int(late[rows].sum()),
                Spread.of(period[rows]),
                Spread.of(work[rows]),
                Spread.of(busy[rows]),
            )
        swaps = [
            Swap(str(kinds[i]), latency, float(work[i]), float(work[i + 1]))
            for i, latency in self._swaps
            if kinds[i]
        ]
        return LivePeriods(times, swaps)
