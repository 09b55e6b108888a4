"""Sessions that measure what a live map costs, run shortly."""

from pathlib import Path

import pytest

from apps.studies.live_map import __main__ as tables
from apps.studies.live_map.cases import (
    FULL,
    QUICK,
    QUIET,
    LivePeriods,
    measure_periods,
    measure_unknown,
)
from apps.studies.live_map.memory import measure_memory
from apps.studies.live_map.session import LiveSession
from remosplat_drake.app.scenario import Scenario, load_scenario
from remosplat_drake.app.scene_config import FREE, OBSTACLE
from remosplat_drake.app.world import load_world

QUICKLY = """
control_period: 0.05
wrist_camera: {width: 96, height: 72}
teleop: {scan: {dwell: 0.1, timeout: 0.4}}
mapping: {frames: 3, voxel: 0.1, discs: 2000}
controller: {guidance: {enabled: false}}
"""


def live_scenario(text: str = "") -> Scenario:
    return load_scenario("StudioLive", QUICKLY + text)


def session(scenario: Scenario, folder: Path) -> LiveSession:
    return LiveSession(scenario, load_world(scenario, blank=True), folder)


@pytest.mark.slow
@pytest.mark.usefixtures("open3d")
def test_by_the_clock_every_kind_of_map_is_made(tmp_path):
    scenario, folder = live_scenario(), tmp_path / "session"
    stages = []
    with session(scenario, folder) as live:
        periods = measure_periods(
            live, folder, rounds=1, rest=0.5, on_stage=stages.append
        )
        unknown = measure_unknown(live, scenario)
    assert stages == ["scanning", QUIET, QUICK, QUIET, FULL]
    assert list(periods.times) == [QUIET, QUICK, FULL]
    for times in periods.times.values():
        assert times.ticks > 0
        assert times.late <= times.ticks
        assert 0 < times.work.p50 <= times.work.p99 <= times.work.max
    assert [swap.effort for swap in periods.swaps] == [QUICK, FULL]
    assert set(unknown) == {OBSTACLE, FREE}
    check_tables(periods, unknown)


def check_tables(periods: LivePeriods, unknown) -> None:
    assert tables.period_table(periods, "a page").row_count == 3
    assert tables.swap_table(periods, "a page").row_count == 2
    assert tables.unknown_table(unknown, "a page").row_count == 2


@pytest.mark.slow
@pytest.mark.usefixtures("open3d")
def test_memory_is_watched_while_maps_come_and_go(tmp_path):
    scenario = live_scenario()
    scenario.mapping.latency = 1.0
    times = []
    with session(scenario, tmp_path / "session") as live:
        memory = measure_memory(live, 0.7, on_time=times.append)
    # A first map, and after that two frames and an undo.
    assert memory.maps == 3
    assert times == sorted(times)
    for use in (memory.control, memory.mapping):
        assert 50 < use.first <= use.most
        assert 50 < use.last <= use.most
    assert tables.memory_table(memory).row_count == 2
