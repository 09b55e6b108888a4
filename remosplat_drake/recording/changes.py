"""What is worth an event: the differences between two ticks."""

import dataclasses as dc
from collections.abc import Iterator
from typing import Any

from remosplat_drake.recording.events import (
    MAP,
    REQUEST,
    SUPERVISOR,
    TARGET,
    TROUBLE,
    Event,
)
from remosplat_drake.recording.run_log import NO_MAP
from remosplat_drake.signals.supervisor_state import SupervisorState


@dc.dataclass(frozen=True, eq=False)
class Surroundings:
    """What a tick finds besides the controller's report; None: not there.

    A log is below those who make maps and targets, and reads no more of what
    they say than is named here.

    Attributes:
        supervision: What the supervisor is at.
        map_status: What the live map is at; its `scene_map` with `version`
            and `quality`, and its `trouble` are read.
        target: What moves the target; its `text` is read.
        requests: What was asked of the map so far, a dataclass: counters,
            and objects that replace each other.
    """

    supervision: SupervisorState | None = None
    map_status: Any = None
    target: Any = None
    requests: Any = None

    @property
    def mode(self) -> str:
        """The supervisor's mode, empty without one."""
        return "" if self.supervision is None else self.supervision.mode

    @property
    def map_version(self) -> int:
        """Version of the map, `NO_MAP` where it does not change."""
        status = self.map_status
        return NO_MAP if status is None else status.scene_map.version


def changes(
    before: Surroundings, now: Surroundings, time: float
) -> Iterator[Event]:
    """The events between two ticks, the later one at `time` [s]."""
    if now.supervision is not before.supervision:
        yield from _supervision_changes(before, now, time)
    if now.map_status is not before.map_status:
        yield from _map_changes(before, now, time)
    if now.target is not before.target:
        yield from _target_changes(before, now, time)
    if now.requests is not before.requests:
        yield from _new_requests(before, now, time)


def _supervision_changes(
    before: Surroundings, now: Surroundings, time: float
) -> Iterator[Event]:
    if now.supervision is not None and now.mode != before.mode:
        parts = (now.mode, now.supervision.reason)
        yield Event(time, SUPERVISOR, ": ".join(filter(None, parts)))


def _map_changes(
    before: Surroundings, now: Surroundings, time: float
) -> Iterator[Event]:
    if now.map_version != before.map_version:
        quality = now.map_status.scene_map.quality
        yield Event(time, MAP, quality, now.map_version)
    known = before.map_status and before.map_status.trouble
    trouble = now.map_status.trouble
    if trouble and trouble != known:
        yield Event(time, TROUBLE, trouble)


def _target_changes(
    before: Surroundings, now: Surroundings, time: float
) -> Iterator[Event]:
    known = before.target and before.target.text
    if now.target.text not in ("", known):
        yield Event(time, TARGET, now.target.text)


def _new_requests(
    before: Surroundings, now: Surroundings, time: float
) -> Iterator[Event]:
    for field in dc.fields(now.requests):
        value = getattr(now.requests, field.name)
        known = getattr(before.requests, field.name, None)
        if isinstance(value, int):
            is_new = value > (known or 0)
        else:
            is_new = value is not None and value is not known
        if is_new:
            yield Event(time, REQUEST, field.name)
