"""Measures the memory of a live map over a long session."""

import dataclasses as dc
import gc
from collections.abc import Callable
from itertools import cycle

from apps.studies.live_map.cases import first_map
from apps.studies.live_map.memory_use import (
    MemoryTrend,
    MemoryUse,
    memory_of,
    trend,
)
from apps.studies.live_map.session import LiveSession
from remosplat_drake.base.real_time import garbage_collection_disabled
from remosplat_drake.signals.map_requests import MapRequests

_LOOKS = 1.0
"""Period at which memory is sampled [s]."""

_EVERY = 15.0
"""Time between two requests to the map while memory is sampled [s]."""

_USE = (
    *[MapRequests(frames=1)] * 2,
    MapRequests(undos=1),
    MapRequests(frames=1),
    MapRequests(refines=1),
    MapRequests(undos=1),
)
"""Requests to the map, made in turns while memory is sampled."""


@dc.dataclass(frozen=True)
class LiveMemory:
    """Memory of a session that runs as fast as possible.

    Attributes:
        minutes: Simulated time [min].
        maps: Number of changes of the map.
        control: Memory of the control process.
        mapping: Memory of the mapping process.
    """

    minutes: float
    maps: int
    control: MemoryTrend
    mapping: MemoryTrend


def measure_memory(
    session: LiveSession,
    minutes: float,
    *,
    on_time: Callable[[float], None] = lambda time: None,
) -> LiveMemory:
    """Uses the map for a long time, as fast as possible, and samples memory.

    Only young garbage is collected, as with the real robot, so objects in
    reference cycles that live longer than a tick would accumulate.

    Args:
        session: New session, with a fixed latency.
        minutes: Simulated time after the scan [min].
        on_time: Callback for the simulated time since the scan [s].

    Raises:
        RemoSplatError: The session gets no first map.
    """
    looked: list[float] = []
    control: list[MemoryUse] = []
    mapping: list[MemoryUse] = []
    wishes = cycle(_USE)
    with garbage_collection_disabled():
        for _ in first_map(session):
            session.tick()
        start = asked = session.time
        while session.time < start + 60 * minutes:
            session.move_on()
            session.tick()
            gc.collect(1)
            if session.status.is_building:
                continue
            if session.time >= asked + _EVERY:
                asked = session.time
                session.ask(next(wishes))
            elif not looked or session.time >= 60 * looked[-1] + _LOOKS:
                looked.append(session.time / 60)
                control.append(memory_of())
                mapping.append(memory_of(session.pid))
                on_time(session.time - start)
    return LiveMemory(
        minutes,
        session.status.swaps,
        trend(looked, control),
        trend(looked, mapping),
    )
