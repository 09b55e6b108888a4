"""`remosplat teleop` as people use it: a process, a page, a real browser."""

import signal
import socket
import subprocess
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from browser import Browser, find_chromium, open_browser
from patience import PATIENCE
from runs import address, command_line, remosplat

from remosplat_drake.mapping.store.map_file import open_map
from remosplat_drake.mapping.store.session import Session
from remosplat_drake.recording.events import MAP, Event, read_events
from remosplat_drake.recording.run_log import read_log
from remosplat_drake.recording.trajectory_log import EVENTS, LOG

COARSE = (
    "{mapping: {frames: 4, voxel: 0.08, discs: 6000},"
    " wrist_camera: {width: 160, height: 120},"
    " teleop: {workspace_lower: [0.2, -0.6, 0.4],"
    " workspace_upper: [1.4, 0.6, 1.2]}}"
)
HOME = np.array([0.634, 0.0, 0.793])
"""Where the hand is at the start [m]."""

LOWER, UPPER = np.array([1.07, -0.21, 0.56]), np.array([1.23, 0.01, 0.74])
"""A box around what the button puts on the table, without the table [m]."""


class Operator:
    """A person at the page of a session, with access to its folder."""

    def __init__(self, tab: Browser, session: Path, robot):
        self.tab, self.session, self._robot = tab, session, robot
        self._run = session / "runs" / "0001"

    def press(self, label: str):
        """Clicks a button."""
        self.tab.click(".remosplat-button", text=label)

    def move(self, axis: str, ends: tuple[float, float]):
        """Drags a slider from one place to another one."""
        self.tab.drag(".cr:has(.remosplat-slider) .slider", ends, axis)

    def line(self, topic: str) -> str:
        """What the page says about a topic."""
        text = f"document.querySelector('[data-topic={topic}]')?.innerText"
        return self.tab.evaluate(f"{text} ?? ''")

    @property
    def bar(self) -> str:
        """How things stand, as the page says it."""
        bar = "document.querySelector('#bar').innerText"
        return self.tab.evaluate(bar)

    @property
    def said(self) -> str:
        """All lines of the page."""
        notes = "[...document.querySelectorAll('#notes p')]"
        return self.tab.evaluate(f"{notes}.map(n => n.innerText).join('; ')")

    def until(self, condition: Callable[[], bool]):
        """Waits until something is so."""
        end = time.monotonic() + PATIENCE
        while not condition():
            assert time.monotonic() < end, (self.said, self.events)
            time.sleep(0.1)

    def until_said(self, topic: str, text: str):
        """Waits until the page says something about a topic."""
        self.until(lambda: text in self.line(topic))

    @property
    def events(self) -> list[Event]:
        """What has happened so far."""
        return read_events(self._run / EVENTS)

    @property
    def maps(self) -> list[int | None]:
        """Versions of the map so far."""
        return [event.version for event in self.events if event.kind == MAP]

    @property
    def X_WE(self) -> np.ndarray:
        """Where the hand was a second ago at most, shape (4, 4)."""
        q = read_log(self._run / LOG).rows["q"][-1]
        return self._robot.end_effector_pose(q)

    @property
    def p_WE(self) -> np.ndarray:
        """Its position, shape (3,) [m]."""
        return self.X_WE[:3, 3]


@pytest.fixture
def process(tmp_path) -> Iterator[subprocess.Popen[str]]:
    """A session of the studio, on a port of its own."""
    with socket.socket() as probe:
        probe.bind(("localhost", 0))
        port = probe.getsockname()[1]
    arguments = "StudioLive", "--session", tmp_path / "session"
    with subprocess.Popen(
        command_line(
            *("teleop", *arguments, "--port", str(port)),
            *("--viewer", "meshcat"),
            *("--scenario-text", COARSE),
        ),
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        try:
            yield process
        finally:
            process.kill()


def discs_at_the_object(session: Path, version: int) -> int:
    """How many discs of a map are on what was put on the table."""
    path = session / "maps" / f"map_{version:04d}.rsmap"
    splat_W = open_map(path).splat_W
    assert splat_W is not None
    inside = (splat_W.p_GK > LOWER) & (splat_W.p_GK < UPPER)
    return int(inside.all(axis=1).sum())


@pytest.mark.slow
@pytest.mark.browser
@pytest.mark.skipif(
    find_chromium() is None, reason="needs chromium on the PATH"
)
def test_an_operator_maps_drives_stops_and_comes_back(
    process, tmp_path, frankie
):
    session = tmp_path / "session"
    with open_browser((1400, 900)) as tab:
        tab.draw_nothing()
        tab.open(address(process))
        tab.wait_for("document.querySelectorAll('.remosplat-slider').length")
        operator = Operator(tab, session, frankie)
        scan_and_drive(operator)
        see_what_changes(operator)
        stop_and_hold(operator)
        process.send_signal(signal.SIGINT)
        code = process.wait(PATIENCE)
        assert process.stderr is not None
        assert code == 0, process.stderr.read()
    comes_back(session, operator.maps)


def scan_and_drive(operator: Operator):
    """The first map, and a robot that follows the sliders."""
    operator.until_said("map", "none yet: scan first")
    operator.press("Scan")
    operator.until(lambda: operator.maps == [0, 1])
    operator.until_said("map", "version 1: 4 frames")
    operator.press("Go home")
    operator.until(lambda: np.linalg.norm(operator.p_WE - HOME) < 0.01)
    operator.move("x [m]", (0.36, 0.45))
    operator.until_said("target", "following the sliders")
    operator.until(lambda: operator.p_WE[0] > HOME[0] + 0.07)
    operator.move("y [m]", (0.5, 0.6))
    operator.until(lambda: operator.p_WE[1] > HOME[1] + 0.05)
    # The hand, and the camera with it, look ahead onto the table.
    operator.move("pitch", (0.5, 0.28))
    operator.until(lambda: operator.X_WE[0, 2] > 0.5)


def see_what_changes(operator: Operator):
    """Frames by and by, something on the table, and back."""
    session = operator.session
    operator.press("Add a frame")
    operator.until(lambda: operator.maps == [0, 1, 2])
    assert discs_at_the_object(session, 2) == 0
    operator.press("Put or take an object")
    operator.press("Add a frame")
    operator.until(lambda: operator.maps == [0, 1, 2, 3])
    assert discs_at_the_object(session, 3) > 20
    operator.press("Undo")
    operator.until(lambda: operator.maps == [0, 1, 2, 3, 2])
    operator.press("Save splat")
    operator.until(lambda: any(session.glob("*.ply")))


def stop_and_hold(operator: Operator):
    """The red button, the green one, and hold."""
    operator.tab.click(".remosplat-stop")
    operator.until(lambda: "stop button" in operator.bar)
    operator.tab.click(".remosplat-release")
    operator.until(lambda: "Live" in operator.bar)
    operator.press("Hold")
    operator.until_said("target", "hold")


def comes_back(session: Path, maps: list[int | None]):
    """All is there, plays again, and can be gone on with."""
    made = Session.open(session)
    assert made.head == maps[-1] and len(made.versions) == 3
    assert made.head_map is not None and open_map(made.head_map).version == 2
    replayed = remosplat("replay", session, "--no-hold")
    assert replayed.returncode == 0, replayed.stderr
    script = session.parent / "script.yaml"
    script.write_text("steps: [{time: 0, press: hold}]")
    again = remosplat(
        *("teleop", "--session", session, "--trajectory", script),
        *("--headless", "--duration", "0.2"),
    )
    assert again.returncode == 0, again.stderr
    rows = read_log(session / "runs" / "0002" / LOG).rows
    assert set(rows["map_version"]) == {2}
