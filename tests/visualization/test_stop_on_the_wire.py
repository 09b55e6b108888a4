"""A page from elsewhere, in a real browser, and a robot behind a wire.

Meshcat does not identify visitors: any page may send what its own would.
"""

import json
import time
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import pytest
from browser import open_browser
from page_messages import packed
from patience import PATIENCE
from pydrake.lcm import DrakeLcm
from runs import PATIENT
from screenshot import find_chromium

from remosplat_drake.acceptance.hardware_processes import (
    controller,
    end,
    free_url,
    robot,
    wire_works,
)
from remosplat_drake.acceptance.motion_judge import TrueRun, judge_stop
from remosplat_drake.acceptance.wire_tap import WireTap
from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.world import load_world
from remosplat_drake.hardware.client.operator import Operator
from remosplat_drake.safety.supervisor_system import STOP_BUTTON
from remosplat_drake.signals.supervisor_state import STOPPED, UNARMED
from remosplat_drake.visualization.page_state import RELEASE, STOP
from remosplat_drake.visualization.page_style import BUTTONS

TOUR = f"{PATIENT}time_limit: 900\ntargets:" + 8 * (
    "\n- {translation: [1.15, 0.0, 0.66], rpy_deg: [180, 0, 0]}"
    "\n- {translation: [0.95, 0.45, 0.95], rpy_deg: [180, 0, 0]}"
)
"""Up and down, for longer than a browser takes for a click."""

FOREIGN = """<!DOCTYPE html>
<script>
let opened = false;
const socket = new WebSocket("%s");
socket.onopen = () => { opened = true; };
const press = (bytes) => socket.send(new Uint8Array(bytes));
</script>
"""
"""A web page that presses buttons of another one."""


class Log:
    """What the controller's process has logged so far."""

    def __init__(self, path: Path):
        self._path = path

    def latest(self, key: str):
        """The latest value of that name; None before the first one."""
        lines = self._path.read_text().splitlines()
        values = [json.loads(line).get(key) for line in lines]
        return next((v for v in reversed(values) if v is not None), None)


@pytest.mark.slow
@pytest.mark.browser
@pytest.mark.skipif(
    find_chromium() is None, reason="needs chromium on the PATH"
)
@pytest.mark.skipif(
    not wire_works(), reason="this computer hears none of its own multicasts"
)
def test_a_foreign_page_stops_the_robot_and_does_nothing_else(tmp_path):
    url, path = free_url(), tmp_path / "log.jsonl"
    motion, log, tap = tmp_path / "motion.npz", Log(path), WireTap(url)
    operator = Operator(DrakeLcm(url))
    with ExitStack() as stack:
        tab = stack.enter_context(open_browser((600, 400)))
        process = stack.enter_context(
            controller(url, path, "--page", "--scenario-text", TOUR)
        )
        assert tap.wait(lambda: log.latest("socket") is not None, PATIENCE)
        foreign = tmp_path / "foreign.html"
        foreign.write_text(FOREIGN % log.latest("socket"))
        tab.open(foreign.as_uri())
        tab.wait_for("opened")

        def press(name: str) -> None:
            data = packed({"type": "button", "name": name})
            tab.evaluate(f"press({list(data)})")

        stand_in = stack.enter_context(robot(url, "--record", str(motion)))
        assert tap.wait(lambda: log.latest("mode") == STOPPED, PATIENCE)
        assert log.latest("reason") == UNARMED
        press(BUTTONS[RELEASE])
        tap.listen_for(1.0)
        assert log.latest("mode") == STOPPED and tap.moving_at is None
        arm(operator)
        assert tap.wait(lambda: tap.moving_at is not None, PATIENCE)
        tap.listen_for(0.5)
        pressed = time.time()
        press(BUTTONS[STOP])
        assert tap.wait(lambda: log.latest("reason") == STOP_BUTTON, PATIENCE)
        assert tap.wait(lambda: log.latest("mode") == STOPPED, PATIENCE)
        press(BUTTONS[RELEASE])
        tap.listen_for(1.5)
        assert process.poll() is None
        assert log.latest("mode") == STOPPED
        released = time.time()
        arm(operator)
        # It sets off, and a second later it is still under way.
        assert tap.wait(lambda: tap.latest > released + 1.0, PATIENCE)
        end(process)
        end(stand_in)
    run = TrueRun.read(motion)
    stop = judge_stop(run.until(released), pressed, monitored_robot())
    assert stop.stays
    assert np.abs(run.since(released).u).max() > 0.1


def arm(operator: Operator) -> None:
    """As a person does when one controller is waiting."""
    end, leases = time.monotonic() + PATIENCE, []
    while not leases:
        assert time.monotonic() < end
        leases = operator.listen_for(0.3)
    operator.arm(leases[0].identity.session)


def monitored_robot():
    return load_world(load_scenario()).robot
