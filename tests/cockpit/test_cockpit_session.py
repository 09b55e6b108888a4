"""A whole session at the cockpit, with the program that people start."""

import numpy as np
import pytest

pytest.importorskip("viser")

from browser import find_chromium
from cockpit_session import insist, open_session

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
    # RELEASE is confirmed within 5 s, which pictures may take.
    with open_session(
        "StudioLive", session, "--scenario-text", COARSE, size=(600, 500)
    ) as operator:
        operator.wait_for_text("none yet: scan first")
        insist(operator, lambda: operator.press("Scan"), "scan: view")
        insist(operator, lambda: operator.press("STOP"), "stop button")
        insist(operator, lambda: operator.press("Scan"), "version ")
        insist(
            operator, lambda: operator.key("KeyW", "w"), "following the cockpit"
        )
    events = read_events(run / EVENTS)
    assert any("stop button" in event.text for event in events)
    assert [e.version for e in events if e.kind == MAP][:2] == [0, 1]
    q = read_log(run / LOG).rows["q"]
    assert np.abs(q - q[0]).max() > 0.05
