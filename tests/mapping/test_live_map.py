"""The live map in a diagram: swaps between ticks, and nothing in between."""

import dataclasses as dc
import os
import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from map_station import PERIOD, Station
from mapped_table import (
    CONFIG,
    looking_around,
    make_job,
    table_world,
)
from patience import PATIENCE

from remosplat_drake.app.world import World
from remosplat_drake.mapping.live_map_memory import news
from remosplat_drake.mapping.mapping_process import DIED, MappingProcess
from remosplat_drake.mapping.messages import (
    AddFrame,
    Build,
    Save,
    ShowScene,
    Undo,
)
from remosplat_drake.scene.mover import Mover, Movers
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.signals.map_requests import MapRequests
from remosplat_drake.signals.scene_map import SceneMap

LATENCY = 0.5


@pytest.fixture(scope="module")
def table() -> World:
    return table_world()


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """Of the session that the tests share."""
    return tmp_path_factory.mktemp("live") / "session"


@pytest.fixture(scope="module")
def process(rendering, table, folder) -> Iterator[MappingProcess]:
    process = MappingProcess(make_job(table, folder))
    yield process
    process.close()


@pytest.fixture(scope="module")
def station(table, process) -> Station:
    """Its session goes on from test to test."""
    return Station(table, process)


FRAME, QUICK, FULL = AddFrame, Build("quick"), Build("full")
SCENE = PrimitiveScene()


@pytest.mark.parametrize(
    ("wanted", "expected"),
    [
        ({}, []),
        ({"frames": 1}, [FRAME, QUICK]),
        ({"frames": 1, "unfinished": 1}, [FRAME]),
        ({"frames": 3, "unfinished": 2}, [FRAME] * 3 + [QUICK]),
        # A scan that is broken off: its last frame was the last one.
        ({"unfinished": -1}, [QUICK]),
        ({"refines": 2}, [FULL]),
        ({"undos": 2, "saves": 3}, [Undo(), Undo(), Save()]),
    ],
)
def test_what_is_new_is_passed_on_once(wanted, expected):
    known = MapRequests(frames=4, refines=1, unfinished=2, scene=SCENE)
    wanted = known + MapRequests(**wanted)
    requests = news(known, wanted, np.ones(2), 1.5, Movers(1.5))
    kinds = [AddFrame if isinstance(r, AddFrame) else r for r in requests]
    assert kinds == expected


def test_another_scene_is_passed_on_before_the_frames():
    known, other = MapRequests(scene=SCENE), PrimitiveScene()
    wanted = known + MapRequests(frames=1, scene=other)
    passing = Movers(1.4, [Mover.sphere("ball", np.ones(3), 0.1)])
    shown, frame, _ = news(known, wanted, np.ones(2), 1.5, passing)
    assert isinstance(shown, ShowScene) and shown.scene is other
    assert isinstance(frame, AddFrame) and frame.time == 1.5
    assert frame.passing is passing
    np.testing.assert_array_equal(frame.q, np.ones(2))


def test_before_the_first_frame_the_scenario_counts(station, table):
    station.advance(5)
    assert station.asked_field is table.field
    assert station.status.scene_map is station.initial
    assert station.status.swaps == 0
    assert station.age == 0.0


@contextmanager
def paused(process: MappingProcess) -> Iterator[None]:
    """Nothing is answered meanwhile."""
    while process.process is None or process.process.pid is None:
        time.sleep(0.005)
    os.kill(process.process.pid, signal.SIGSTOP)
    try:
        yield
    finally:
        os.kill(process.process.pid, signal.SIGCONT)


def test_a_session_from_the_first_scan_to_the_death_of_its_process(station):
    with paused(station.process):
        requests = station.scan()
        taken = station.latest
        assert station.status.is_building
    station.until_quiet()
    first = station.status
    assert (first.scene_map.version, first.swaps, first.frames) == (1, 1, 3)
    assert first.text == f"version 1: {first.scene_map.quality}"
    assert station.asked_field is first.scene_map.field
    assert first.scene_map.time == pytest.approx(taken)
    assert station.age == pytest.approx(station.root.get_time() - taken)
    # Back to the beginning.
    requests += MapRequests(undos=1)
    station.ask(requests)
    station.advance()
    station.until_quiet()
    assert station.status.scene_map is station.initial
    assert station.status.swaps == 2
    assert station.age == 0.0
    # Without its process the map stays; a request starts it again.
    assert station.process.process is not None
    station.process.process.kill()
    station.process.process.join()
    station.advance(2)
    assert station.status.trouble == DIED
    assert station.status.scene_map is station.initial
    station.scan()
    station.until_quiet()
    assert station.status.scene_map.version == 2
    assert station.status.trouble == ""


def test_a_scan_that_is_broken_off_gives_a_map(station):
    before = station.status.scene_map
    requests = station.requests
    for q in looking_around(station.world, 2, seed=7):
        station.stand(q)
        requests += MapRequests(frames=1, unfinished=1)
        station.ask(requests)
        station.advance()
    station.until_quiet()
    assert station.status.scene_map is before
    station.ask(requests + MapRequests(unfinished=-1))
    station.advance()
    station.until_quiet()
    after = station.status.scene_map
    assert after.version == before.version + 1
    assert len(after.frames) == len(before.frames) + 2


@pytest.mark.slow
@pytest.mark.usefixtures("rendering")
def test_with_a_fixed_latency_a_map_counts_from_its_tick_on(table, tmp_path):
    config = dc.replace(CONFIG, latency=LATENCY)
    job = make_job(table, tmp_path / "session", config)
    station = Station(table, MappingProcess(job), latency=LATENCY)
    station.scan()
    asked = station.latest
    station.simulator.AdvanceTo(asked + LATENCY - 0.5 * PERIOD)
    assert station.status.scene_map.version == 0
    station.simulator.AdvanceTo(asked + LATENCY + 0.5 * PERIOD)
    assert station.status.scene_map.version == 1
    station.process.close()


def test_a_map_that_is_damaged_leaves_the_old_one(station, folder):
    before = station.status.scene_map
    name = f"map_{before.version + 1:04d}.rsmap"
    station.scan()
    damage_when_there(folder / "maps" / name)
    station.until_quiet()
    assert station.status.scene_map is before
    assert "the previous map stays in use" in station.status.trouble
    assert name in station.status.trouble


def damage_when_there(path: Path) -> None:
    end = time.monotonic() + PATIENCE
    while not path.exists():
        assert time.monotonic() < end
        time.sleep(0.005)
    path.write_bytes(path.read_bytes()[:1000])


def test_a_reopened_map_counts_at_once(table, process):
    field = table.truth_field
    reopened = SceneMap(3, 2, ("frame 1", "frame 2"), 77.0, field)
    station = Station(table, process, reopened=reopened)
    assert station.asked_field is field
    assert station.status.frames == 2
    # Its clock was another one: the age counts from the start of this run.
    assert station.age == 0.0


def test_a_camera_whose_clock_is_ahead_is_not_old(table, process):
    reopened = SceneMap(3, 2, ("frame 1",), 0.05, table.truth_field)
    station = Station(table, process, reopened=reopened)
    assert station.age == 0.0
