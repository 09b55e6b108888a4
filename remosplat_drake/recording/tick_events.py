"""Finds the events between two control ticks."""

import dataclasses as dc
from collections.abc import Iterator

from remosplat_drake.recording.events import (
    MAP,
    MOTION_STATUS,
    REQUEST,
    SUPERVISOR,
    TARGET,
    TROUBLE,
    Event,
)
from remosplat_drake.recording.run_log import NO_MAP
from remosplat_drake.signals.map_requests import MapRequests
from remosplat_drake.signals.map_status import MapStatus
from remosplat_drake.signals.motion_status import (
    HELD,
    STOPPED,
    STOPPING,
    WAITING,
    MotionStatus,
)
from remosplat_drake.signals.station_status import StationStatus
from remosplat_drake.signals.supervisor_state import SupervisorState
from remosplat_drake.signals.target_state import TargetState

_OF_THE_SUPERVISOR = (WAITING, STOPPING, STOPPED)
"""Kinds of `MotionStatus` that events of the supervisor also report."""


@dc.dataclass(frozen=True, eq=False)
class LoggedSignals:
    """Signals of a tick, in addition to the controller's report.

    A signal is None if the diagram has no system that outputs it.

    Attributes:
        supervision: State of the safety supervisor.
        map_status: Status of the live map.
        target: State of the target that an operator moves.
        requests: All requests to the live map so far.
        station: Status of the station.
        motion_status: The robot's `MotionStatus`.
    """

    supervision: SupervisorState | None = None
    map_status: MapStatus | None = None
    target: TargetState | None = None
    requests: MapRequests | None = None
    station: StationStatus | None = None
    motion_status: MotionStatus | None = None

    @property
    def mode(self) -> str:
        """Mode of the supervisor; empty if there is none."""
        return "" if self.supervision is None else self.supervision.mode

    @property
    def map_version(self) -> int:
        """Version of the map; `NO_MAP` in a run whose map does not change."""
        status = self.map_status
        return NO_MAP if status is None else status.scene_map.version


def events_between(
    before: LoggedSignals, now: LoggedSignals, time: float
) -> Iterator[Event]:
    """Finds the events between two control ticks.

    Args:
        before: The signals of the earlier tick.
        now: The signals of the later tick.
        time: Time of the later tick, which becomes the time of the events [s].
    """
    if now.supervision is not before.supervision:
        yield from _supervision_changes(before, now, time)
    if now.motion_status is not before.motion_status:
        yield from _motion_status_changes(before, now, time)
    if now.map_status is not before.map_status:
        yield from _map_changes(before, now, time)
    if now.target is not before.target:
        yield from _target_changes(before, now, time)
    if now.requests is not before.requests:
        yield from _new_requests(before, now, time)


def _supervision_changes(
    before: LoggedSignals, now: LoggedSignals, time: float
) -> Iterator[Event]:
    if now.supervision is not None and now.mode != before.mode:
        parts = (now.mode, now.supervision.reason)
        yield Event(time, SUPERVISOR, ": ".join(filter(None, parts)))


def _motion_status_changes(
    before: LoggedSignals, now: LoggedSignals, time: float
) -> Iterator[Event]:
    if now.motion_status is None or _is_supervisor_event(now.motion_status):
        return
    known = before.motion_status
    if known is None or now.motion_status.is_news_after(known):
        yield _motion_status_event(now.motion_status, time)


def _is_supervisor_event(motion_status: MotionStatus) -> bool:
    """Whether an event of the supervisor states the same as a motion status.

    An event of the supervisor does not contain the place of a stop, which a
    replay highlights.
    """
    has_place = motion_status.link != "" or motion_status.p_W is not None
    is_place = motion_status.kind == STOPPED and has_place
    return motion_status.kind in _OF_THE_SUPERVISOR and not is_place


def _motion_status_event(motion_status: MotionStatus, time: float) -> Event:
    if motion_status.kind not in (HELD, STOPPED):
        return Event(time, MOTION_STATUS, motion_status.text)
    place = None
    if motion_status.p_W is not None:
        x, y, z = map(float, motion_status.p_W)
        place = x, y, z
    return Event(
        time,
        MOTION_STATUS,
        motion_status.text,
        link=motion_status.link,
        place=place,
    )


def _map_changes(
    before: LoggedSignals, now: LoggedSignals, time: float
) -> Iterator[Event]:
    status = now.map_status
    if status is None:
        return
    if now.map_version != before.map_version:
        yield Event(time, MAP, status.scene_map.quality, now.map_version)
    known = before.map_status and before.map_status.trouble
    if status.trouble and status.trouble != known:
        yield Event(time, TROUBLE, status.trouble)


def _target_changes(
    before: LoggedSignals, now: LoggedSignals, time: float
) -> Iterator[Event]:
    known = before.target and before.target.text
    if now.target is not None and now.target.text not in ("", known):
        yield Event(time, TARGET, now.target.text)


def _new_requests(
    before: LoggedSignals, now: LoggedSignals, time: float
) -> Iterator[Event]:
    if now.requests is None:
        return
    for field in dc.fields(now.requests):
        value = getattr(now.requests, field.name)
        known = getattr(before.requests, field.name, None)
        if isinstance(value, int):
            is_new = value > (known or 0)
        else:
            is_new = value is not None and value is not known
        if is_new:
            yield Event(time, REQUEST, field.name)
