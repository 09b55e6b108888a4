"""A log as an animation in the page."""

import time as clock
from itertools import pairwise

import numpy as np
import pytest
from browser import open_browser
from logged_run import SWAP, make_session
from pydrake.systems.sensors import ImageIo
from screenshot import find_chromium

from remosplat_drake.app.recorded_run import load_recorded_run
from remosplat_drake.recording.events import MOTION_STATUS, SUPERVISOR, Event
from remosplat_drake.recording.events import TARGET as TARGET_EVENT
from remosplat_drake.signals.motion_status import HELD, MOVING, NOT_STARTED
from remosplat_drake.visualization.motion_status_view import LINKS, PLACE
from remosplat_drake.visualization.replay import (
    SPLATS,
    ReplayedMap,
    draw_maps,
    frame_ticks,
    motion_status_at,
    record_replay,
)
from remosplat_drake.visualization.run_view import TARGET

DURATION = 1.0


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    folder = tmp_path_factory.mktemp("replay") / "session"
    make_session(folder, DURATION)
    return load_recorded_run(folder)


def test_frames_are_taken_at_their_times():
    time = 0.01 * np.arange(101)
    np.testing.assert_array_equal(
        frame_ticks(time, period=0.25), [0, 25, 50, 75, 100]
    )
    # A run that is too long has fewer frames a second.
    np.testing.assert_array_equal(
        frame_ticks(time, period=0.01, most=3), [0, 50, 100]
    )
    # Ticks that are far apart are frames, each of them once.
    np.testing.assert_array_equal(
        frame_ticks(np.array([0.0, 1.0, 5.0]), period=0.25), [0, 1, 2]
    )
    np.testing.assert_array_equal(frame_ticks(np.array([2.0])), [0])


def test_what_was_held_is_what_the_events_tell():
    held = Event(1.0, MOTION_STATUS, "held", link="hand", place=(1.0, 2.0, 3.0))
    events = [
        Event(0.0, MOTION_STATUS, "moving"),
        held,
        Event(2.0, TARGET_EVENT, "hold"),
        Event(3.0, SUPERVISOR, "stopping: stop button"),
    ]
    assert motion_status_at([], 1.0) is NOT_STARTED
    assert motion_status_at(events, 0.5).kind == MOVING
    for time in (1.0, 2.5):
        motion_status = motion_status_at(events, time)
        assert (motion_status.kind, motion_status.link) == (HELD, "hand")
        np.testing.assert_array_equal(motion_status.p_W, held.place)
    # A stop has another place, or none.
    assert motion_status_at(events, 3.0).kind == MOVING
    base = Event(3.1, MOTION_STATUS, "stopped: scanner", link="base_link")
    assert motion_status_at([*events, base], 3.2).link == "base_link"


@pytest.mark.parametrize("ends", [False, True])
def test_what_was_held_lights_up(page, recorded, is_visible, pose_of, ends):
    rows = recorded.log.rows
    begin, end = rows["time"][0] + 0.3, rows["time"][0] + 0.6
    events = [
        Event(begin, MOTION_STATUS, "", link="panda_link4", place=(1, 0, 1))
    ]
    if ends:
        events.append(Event(end, MOTION_STATUS, "moving"))
    robot = recorded.world.robot
    maps, _ = recorded.maps()
    record_replay(page, robot, recorded.log, maps, reach=0.5, events=events)
    link = f"{LINKS}/panda_link4"
    for path in (link, PLACE):
        assert is_visible(page.meshcat, path) == (not ends)
    np.testing.assert_allclose(pose_of(page.meshcat, PLACE)[:3, 3], [1, 0, 1])
    if not ends:
        X_WL = robot.body_poses(rows["q"][-1])
        expected = X_WL[robot.tree.index("panda_link4")]
        np.testing.assert_allclose(
            pose_of(page.meshcat, link), expected, atol=1e-12
        )


def test_robot_and_target_end_where_they_were(page, recorded, pose_of):
    maps, problems = recorded.maps()
    assert problems == []
    frames = []
    record_replay(
        page,
        recorded.world.robot,
        recorded.log,
        maps,
        reach=0.5,
        on_frame=lambda done, total: frames.append((done, total)),
    )
    row = recorded.log.rows[-1]
    np.testing.assert_allclose(pose_of(page.meshcat, TARGET)[:3], row["X_WT"])
    robot = recorded.world.robot
    X_WL = robot.body_poses(row["q"])[robot.tree.index("panda_link4")]
    drawn = pose_of(page.meshcat, "/remosplat/robot/panda/panda_link4")
    np.testing.assert_allclose(drawn, X_WL, atol=1e-12)
    assert frames[-1] == (len(frames), len(frames))
    assert 30 <= len(frames) <= 33


def test_each_map_is_on_show_at_its_time(page, recorded, is_visible):
    maps, _ = recorded.maps()
    assert maps.keys() == {0, 1}
    page.start_recording()
    versions = np.array([0, 1, 1, 0])
    draw_maps(page, maps, versions, np.arange(4.0))
    # What happened last is what is on show now: an undo.
    assert is_visible(page.meshcat, f"{SPLATS}/0")
    assert not is_visible(page.meshcat, f"{SPLATS}/1")
    assert page.meshcat.HasPath(f"{SPLATS}/1")


def test_a_lost_map_leaves_the_motion(page, recorded):
    record_replay(
        page,
        recorded.world.robot,
        recorded.log,
        {0: ReplayedMap(), 1: ReplayedMap()},
        reach=0.5,
    )
    assert not page.meshcat.HasPath(f"{SPLATS}/0")
    assert page.meshcat.HasPath(TARGET)


@pytest.mark.slow
@pytest.mark.browser
@pytest.mark.skipif(
    find_chromium() is None, reason="needs chromium on the PATH"
)
def test_a_browser_plays_the_saved_page(page, recorded, tmp_path):
    """The board's right half goes when the map does, and the arm moves."""
    maps, _ = recorded.maps()
    record_replay(page, recorded.world.robot, recorded.log, maps, reach=0.5)
    path = tmp_path / "replay.html"
    page.save_html(path)
    pictures = []
    with open_browser((700, 450)) as browser:
        browser.open(path.resolve().as_uri())
        browser.wait_for("document.querySelector('#clock')?.textContent")
        duration = browser.evaluate("viewer.animator.duration")
        for time in (0.1, SWAP - 0.05, SWAP + 0.05):
            # Dragging the time line ends the playing.
            browser.evaluate(
                "(() => { const line = document.querySelector('#time');"
                f" line.value = {time};"
                " line.dispatchEvent(new Event('input')); })()"
            )
            clock.sleep(1.0)
            browser.save_picture(tmp_path / "picture.png")
            image = ImageIo().Load(tmp_path / "picture.png").data
            pictures.append(image[:, :, :3].astype(int))
    assert duration == pytest.approx(DURATION, abs=0.1)
    moved, swapped = (
        (np.abs(b - a).max(axis=2) > 30).mean() for a, b in pairwise(pictures)
    )
    assert 0.001 < moved < 0.1 < swapped
