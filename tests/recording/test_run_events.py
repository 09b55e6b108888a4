"""Events: found between two ticks, written as they happen."""

import dataclasses as dc
from types import SimpleNamespace

import numpy as np
import pytest

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.recording.changes import Surroundings, changes
from remosplat_drake.recording.events import (
    MAP,
    REQUEST,
    SUPERVISOR,
    TARGET,
    TROUBLE,
    Event,
    EventWriter,
    read_events,
)
from remosplat_drake.signals.supervisor_state import (
    RUNNING,
    STOPPING,
    SupervisorState,
)


@dc.dataclass(frozen=True)
class Requests:
    frames: int = 0
    undos: int = 0
    scene: object = None


def between(before: Surroundings, now: Surroundings) -> list[Event]:
    return list(changes(before, now, 3.0))


def status(version: int, trouble: str = "") -> SimpleNamespace:
    scene_map = SimpleNamespace(version=version, quality=f"map {version}")
    return SimpleNamespace(scene_map=scene_map, trouble=trouble)


def test_nothing_new_is_no_event():
    now = Surroundings(
        SupervisorState(np.zeros(2)), status(1), None, Requests(2)
    )
    again = Surroundings(
        SupervisorState(np.ones(2)), status(1), None, Requests(2)
    )
    assert between(now, now) == []
    assert between(now, again) == []
    assert between(Surroundings(), Surroundings()) == []


def test_a_stop_has_its_reason():
    before = Surroundings(SupervisorState(np.zeros(2), RUNNING))
    now = Surroundings(
        SupervisorState(np.zeros(2), STOPPING, reason="too near")
    )
    assert between(before, now) == [
        Event(3.0, SUPERVISOR, "stopping: too near")
    ]
    assert between(Surroundings(), before) == [Event(3.0, SUPERVISOR, RUNNING)]


def test_another_map_is_named():
    first, second = Surroundings(None, status(0)), Surroundings(None, status(1))
    assert between(Surroundings(), first) == [Event(3.0, MAP, "map 0", 0)]
    assert between(first, second) == [Event(3.0, MAP, "map 1", 1)]


def test_trouble_is_told_once():
    fine, broken = status(1), status(1, "the mapping process has died")
    events = between(Surroundings(None, fine), Surroundings(None, broken))
    assert events == [Event(3.0, TROUBLE, "the mapping process has died")]
    assert not between(
        Surroundings(None, broken),
        Surroundings(None, status(1, broken.trouble)),
    )
    assert not between(Surroundings(None, broken), Surroundings(None, fine))


def test_what_moves_the_target():
    home, hold = SimpleNamespace(text="go home"), SimpleNamespace(text="hold")
    events = between(Surroundings(target=home), Surroundings(target=hold))
    assert events == [Event(3.0, TARGET, "hold")]
    assert between(Surroundings(), Surroundings(target=home))


def test_counters_that_grew_are_requests():
    before = Surroundings(requests=Requests(1, 1, "a table"))
    now = Surroundings(requests=Requests(1, 2, "a table"))
    assert between(before, now) == [Event(3.0, REQUEST, "undos")]
    assert between(Surroundings(), before) == [
        Event(3.0, REQUEST, "frames"),
        Event(3.0, REQUEST, "undos"),
        Event(3.0, REQUEST, "scene"),
    ]


def test_another_scene_is_a_request():
    before = Surroundings(requests=Requests(scene="a table"))
    now = Surroundings(requests=Requests(scene="a table and a box"))
    assert between(before, now) == [Event(3.0, REQUEST, "scene")]
    assert between(now, Surroundings(requests=Requests())) == []


def test_events_are_written_at_once_and_read(tmp_path):
    path = tmp_path / "events.jsonl"
    events = [Event(0.1, MAP, "map 1", 1), Event(0.25, TROUBLE, "two\nlines")]
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
    ],
)
def test_what_holds_no_events_is_an_error_of_the_user(tmp_path, content):
    path = tmp_path / "events.jsonl"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(RemoSplatError, match=r"events\.jsonl"):
        read_events(path)
