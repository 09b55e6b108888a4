"""The page's buttons, clicked in a real browser, and a robot behind a wire."""

import json
import time
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import pytest
from browser import open_browser
from patience import PATIENCE
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
from remosplat_drake.signals.supervisor_state import STOPPED

TOUR = f"{PATIENT}time_limit: 900\ntargets:" + 8 * (
    "\n- {translation: [1.15, 0.0, 0.66], rpy_deg: [180, 0, 0]}"
    "\n- {translation: [0.95, 0.45, 0.95], rpy_deg: [180, 0, 0]}"
)
"""Up and down, for longer than a browser takes for a click."""

CLICK_LIMIT = 10.0
"""When a person clicks again, if nothing has come of it [s]."""


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
def test_a_click_stops_the_robot_and_only_a_click_releases_it(tmp_path):
    url, path = free_url(), tmp_path / "log.jsonl"
    motion, log, tap = tmp_path / "motion.npz", Log(path), WireTap(url)
    with ExitStack() as stack:
        tab = stack.enter_context(open_browser((600, 400)))
        process = stack.enter_context(
            controller(url, path, "--page", "--scenario-text", TOUR)
        )
        assert tap.wait(lambda: log.latest("page") is not None, PATIENCE)
        tab.open(log.latest("page"))
        tab.wait_for("document.querySelector('.remosplat-stop') !== null")
        tab.set_drawing(False)
        stand_in = stack.enter_context(robot(url, "--record", str(motion)))
        assert tap.wait(lambda: tap.moving_at is not None, PATIENCE)
        tap.listen_for(0.3)
        clicked = time.time()
        click_until(
            tab, ".remosplat-stop", tap, lambda: log.latest("mode") == STOPPED
        )
        assert log.latest("reason") == "stop button"
        tap.listen_for(1.5)
        assert process.poll() is None
        assert log.latest("mode") == STOPPED
        released = time.time()
        click_until(
            tab, ".remosplat-release", tap, lambda: log.latest("reason") == ""
        )
        # It sets off, and a second later it is still under way.
        assert tap.wait(lambda: tap.latest > released + 1.0, PATIENCE)
        end(process)
        end(stand_in)
    run = TrueRun.read(motion)
    stop = judge_stop(run.until(released), clicked, monitored_robot())
    # A browser without a graphics card takes seconds for a click here.
    assert stop.stays
    assert np.abs(run.since(released).u).max() > 0.1


def click_until(tab, selector: str, tap: WireTap, done: Callable[[], bool]):
    """Like a person: again, if nothing comes of it.

    While the page is drawn anew its lines move, and a click may miss.
    """
    for _ in range(5):
        tab.click(selector)
        if tap.wait(done, CLICK_LIMIT):
            return
    raise AssertionError(f"nothing came of clicks on {selector}")


def monitored_robot():
    return load_world(load_scenario()).robot
