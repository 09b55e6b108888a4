"""Events: found between two ticks, written as they happen."""

import numpy as np
import pytest
from pydrake.math import RigidTransform

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.recording.events import (
    MAP,
    MOTION_STATUS,
    REQUEST,
    SUPERVISOR,
    TARGET,
    TROUBLE,
    Event,
    EventWriter,
    read_events,
)
from remosplat_drake.recording.tick_events import LoggedSignals, events_between
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene
from remosplat_drake.signals.map_requests import MapRequests
from remosplat_drake.signals.map_status import MapStatus
from remosplat_drake.signals.motion_status import (
    HELD,
    MOVING,
    STOPPED,
    MotionStatus,
)
from remosplat_drake.signals.scene_map import SceneMap
from remosplat_drake.signals.supervisor_state import (
    RUNNING,
    STOPPING,
    SupervisorState,
)
from remosplat_drake.signals.target_state import TargetState

TABLE, OTHER = (
    PrimitiveScene(boxes=(Box(RigidTransform([x, 0, 0]), np.full(3, 0.1)),))
    for x in (1.0, 2.0)
)


def between(before: LoggedSignals, now: LoggedSignals) -> list[Event]:
    return list(events_between(before, now, 3.0))


def status(version: int, trouble: str = "") -> MapStatus:
    field = SignedDistanceField(TABLE)
    quality = f"map {version}"
    scene_map = SceneMap(version, None, (), 0.0, field, quality=quality)
    return MapStatus(scene_map, trouble=trouble)


def moved(text: str) -> TargetState:
    return TargetState.at_rest(np.eye(4), text)


def test_nothing_new_is_no_event():
    now = LoggedSignals(
        SupervisorState(np.zeros(2)), status(1), None, MapRequests(2)
    )
    again = LoggedSignals(
        SupervisorState(np.ones(2)), status(1), None, MapRequests(2)
    )
    assert between(now, now) == []
    assert between(now, again) == []
    assert between(LoggedSignals(), LoggedSignals()) == []


def test_a_stop_has_its_reason():
    before = LoggedSignals(SupervisorState(np.zeros(2), RUNNING))
    now = LoggedSignals(
        SupervisorState(np.zeros(2), STOPPING, reason="too near")
    )
    assert between(before, now) == [
        Event(3.0, SUPERVISOR, "stopping: too near")
    ]
    assert between(LoggedSignals(), before) == [Event(3.0, SUPERVISOR, RUNNING)]


def test_what_holds_the_robot_is_an_event():
    moving = MotionStatus(MOVING, "moving, 0.50 m away", 0.5)
    nearer = MotionStatus(MOVING, "moving, 0.40 m away", 0.4)
    p_W = np.array([1.0, 2.0, 3.0])
    held = MotionStatus(HELD, "hand held", 0.4, link="hand", p_W=p_W)
    before = LoggedSignals(motion_status=moving)
    assert between(LoggedSignals(), before) == [
        Event(3.0, MOTION_STATUS, "moving, 0.50 m away")
    ]
    assert between(before, LoggedSignals(motion_status=nearer)) == []
    assert between(before, LoggedSignals(motion_status=held)) == [
        Event(
            3.0, MOTION_STATUS, "hand held", link="hand", place=(1.0, 2.0, 3.0)
        )
    ]
    # The supervisor tells of its stops itself.
    stopped = LoggedSignals(motion_status=MotionStatus(STOPPED, "stopped: why"))
    assert between(before, stopped) == []
    # But it does not tell of their places.
    base = MotionStatus(STOPPED, "stopped: scanner", link="base")
    assert between(before, LoggedSignals(motion_status=base)) == [
        Event(3.0, MOTION_STATUS, "stopped: scanner", link="base")
    ]


def test_another_map_is_named():
    first, second = (
        LoggedSignals(None, status(0)),
        LoggedSignals(None, status(1)),
    )
    assert between(LoggedSignals(), first) == [Event(3.0, MAP, "map 0", 0)]
    assert between(first, second) == [Event(3.0, MAP, "map 1", 1)]


def test_trouble_is_told_once():
    fine, broken = status(1), status(1, "the mapping process has died")
    events = between(LoggedSignals(None, fine), LoggedSignals(None, broken))
    assert events == [Event(3.0, TROUBLE, "the mapping process has died")]
    assert not between(
        LoggedSignals(None, broken),
        LoggedSignals(None, status(1, broken.trouble)),
    )
    assert not between(LoggedSignals(None, broken), LoggedSignals(None, fine))


def test_what_moves_the_target():
    home, hold = moved("go home"), moved("hold")
    events = between(LoggedSignals(target=home), LoggedSignals(target=hold))
    assert events == [Event(3.0, TARGET, "hold")]
    assert between(LoggedSignals(), LoggedSignals(target=home))


def test_counters_that_grew_are_requests():
    before = LoggedSignals(requests=MapRequests(1, undos=1, scene=TABLE))
    now = LoggedSignals(requests=MapRequests(1, undos=2, scene=TABLE))
    assert between(before, now) == [Event(3.0, REQUEST, "undos")]
    assert between(LoggedSignals(), before) == [
        Event(3.0, REQUEST, "frames"),
        Event(3.0, REQUEST, "undos"),
        Event(3.0, REQUEST, "scene"),
    ]


def test_another_scene_is_a_request():
    before = LoggedSignals(requests=MapRequests(scene=TABLE))
    now = LoggedSignals(requests=MapRequests(scene=OTHER))
    assert between(before, now) == [Event(3.0, REQUEST, "scene")]
    assert between(now, LoggedSignals(requests=MapRequests())) == []


def test_events_are_written_at_once_and_read(tmp_path):
    path = tmp_path / "events.jsonl"
    events = [
        Event(0.1, MAP, "map 1", 1),
        Event(0.25, TROUBLE, "two\nlines"),
        Event(0.5, MOTION_STATUS, "held", link="hand", place=(0.5, -1.0, 2.0)),
    ]
    writer = EventWriter(path)
    for event in events:
        writer.append(event)
    assert read_events(path) == events
    writer.close()
    path.write_bytes(path.read_bytes() + b'{"time": 0.3, "ki')
    assert read_events(path) == events
    assert writer.trouble == ""


@pytest.mark.parametrize(
    "content",
    [
        None,
        b"\xff\n",
        b"[1]\n",
        b'{"a": 1}\n',
        b"[" * 10**5 + b"\n",
        b'{"time": "late", "kind": "map", "text": "map 1"}\n',
        b'{"time": NaN, "kind": "map", "text": "map 1"}\n',
        b'{"time": 1, "kind": "map", "text": ["map", "1"]}\n',
        b'{"time": 1, "kind": "map", "text": "", "version": 1.5}\n',
        b'{"time": 1, "kind": "motion_status", "text": "", "link": 7}\n',
        b'{"time": 1, "kind": "motion_status", "text": "", "place": [1, 2]}\n',
        b'{"time": 1,"kind":"motion_status", "text": "", "place": [1,2,"x"]}\n',
    ],
)
def test_what_holds_no_events_is_an_error_of_the_user(tmp_path, content):
    path = tmp_path / "events.jsonl"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(RemoSplatError, match=r"events\.jsonl"):
        read_events(path)
