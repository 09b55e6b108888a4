"""A whole session at the cockpit, with the program that people start."""

import signal
import subprocess
import time
from collections.abc import Callable

import numpy as np
import pytest

pytest.importorskip("viser")

from browser import find_chromium, open_browser
from cockpit_tab import DRAW_NOTHING, CockpitTab
from patience import PATIENCE
from runs import command_line

from remosplat_drake.recording.events import MAP, read_events
from remosplat_drake.recording.run_log import read_log
from remosplat_drake.recording.trajectory_log import EVENTS, LOG

COARSE = (
    "{mapping: {frames: 4, voxel: 0.08, discs: 6000},"
    " wrist_camera: {width: 160, height: 120}}"
)
"""A map that takes a moment."""


@pytest.mark.slow
@pytest.mark.browser
@pytest.mark.skipif(
    find_chromium() is None, reason="needs chromium on the PATH"
)
def test_a_robot_is_driven_stopped_and_released(tmp_path):
    session = tmp_path / "session"
    run = session / "runs" / "0001"
    command = command_line(
        *("teleop", "StudioLive", "--session", session),
        *("--scenario-text", COARSE),
    )
    with subprocess.Popen(
        command, stderr=subprocess.PIPE, text=True
    ) as process:
        try:
            url, code = address(process)
            with open_browser((600, 500)) as tab:
                # RELEASE is confirmed within 5 s, which pictures may take.
                tab.run_first(DRAW_NOTHING)
                operator = CockpitTab(tab, url)
                operator.operate(code)
                operator.wait_for_text("none yet: scan first")
                insist(operator, lambda: operator.press("Scan"), "scan: view")
                insist(operator, lambda: operator.press("STOP"), "stop button")
                insist(operator, lambda: operator.press("Scan"), "version ")
                insist(
                    operator,
                    lambda: operator.key("KeyW", "w"),
                    "following the cockpit",
                )
                assert operator.errors == []
            process.send_signal(signal.SIGINT)
            process.wait(PATIENCE)
        finally:
            process.kill()
    events = read_events(run / EVENTS)
    assert any("stop button" in event.text for event in events)
    assert [e.version for e in events if e.kind == MAP][:2] == [0, 1]
    q = read_log(run / LOG).rows["q"]
    assert np.abs(q - q[0]).max() > 0.05


def insist(operator: CockpitTab, ask: Callable[[], None], result: str):
    """Asks for something; releases a stopped robot, and asks again.

    What is asked of a robot that is stopped is void, and on a busy computer
    the cockpit may fall silent, which stops it.
    """
    end = time.monotonic() + PATIENCE
    asks = True
    while result not in operator.text:
        assert time.monotonic() < end, f"no {result!r} in {operator.text}"
        # The page hides both buttons again if the time to confirm is over, or
        # if an earlier release has had its effect.
        if operator.press_any("Let the robot go", "RELEASE"):
            asks = True
        elif asks:
            ask()
            asks = False
        time.sleep(0.1)


def address(process: subprocess.Popen[str]) -> tuple[str, str]:
    """Address of the page, and the code that makes a client the operator."""
    assert process.stderr is not None
    url = code = ""
    for line in process.stderr:
        if line.startswith("operate at"):
            url = line.split()[2].rstrip(";")
        if "type the code" in line:
            code = line.split("type the code")[1].split()[0]
        if url and code:
            return url, code
    raise AssertionError("the process has gone")
