"""Stop and release on the page: by message, and in a real browser."""

import time

import numpy as np
import pytest
from browser import find_chromium, open_browser
from patience import PATIENCE
from pydrake.math import RigidTransform

from remosplat_drake.app.diagram import Application, build
from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.simulation import run
from remosplat_drake.app.world import load_world
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene
from remosplat_drake.scene.rmmi import write_rmmi
from remosplat_drake.signals.supervisor_state import (
    RUNNING,
    STOPPED,
    SupervisorState,
)
from remosplat_drake.visualization import page_state
from remosplat_drake.visualization.page_style import BUTTONS
from remosplat_drake.visualization.safety_panel import SafetyPanel

STOP, RELEASE = BUTTONS[page_state.STOP], BUTTONS[page_state.RELEASE]

FAR = """
Far:
  scene: {truth: scene.json}
  oracle: !GroundTruth {}
  control_period: 0.02
  time_limit: 6
  targets:
  - translation: [9, 0, 1]
"""


@pytest.fixture
def application(page, tmp_path, without_meshes) -> Application:
    """The robot sets off towards a target nine metres away."""
    box = Box(RigidTransform([-0.8, 0, 0.5]), np.array([0.1, 0.5, 0.5]))
    write_rmmi(tmp_path / "scene.json", PrimitiveScene(boxes=(box,)))
    (tmp_path / "test.yaml").write_text(FAR)
    scenario = load_scenario(f"{tmp_path}/test.yaml")
    return build(scenario, load_world(scenario), page)


class Steps:
    """Does one thing after the other while a run goes on."""

    def __init__(self, *steps):
        self._steps = list(steps)

    def __call__(self, t, error, report):
        if self._steps and t >= self._steps[0][0]:
            self._steps.pop(0)[1]()


def modes_of(application: Application, steps: Steps, **arguments):
    """The result, and (time, mode) of all changes."""
    changes = []
    result = run(
        application,
        on_progress=steps,
        on_supervision=lambda s: changes.append((s.time, s.mode)),
        **arguments,
    )
    return result, changes


def test_stop_and_release(page, application, click):
    """Stops at 1 s and for good at 5 s; released at 3 s."""
    seen, robot = {}, []

    def look(name):
        seen[name] = page.state
        robot.append(page.status["robot"])

    result, changes = modes_of(
        application,
        Steps(
            (0.9, lambda: look("running")),
            (1.0, lambda: click(page.meshcat, STOP)),
            (2.9, lambda: look("stopped")),
            (3.0, lambda: click(page.meshcat, RELEASE)),
            (4.9, lambda: look("released")),
            (5.0, lambda: click(page.meshcat, STOP)),
        ),
        patience=4.0,
    )
    assert result.outcome == "stopped: stop button"
    modes = [mode for _, mode in changes]
    assert modes[2:6] == ["stopping", "stopped", "starting", "running"]
    assert modes[6:] == ["stopping", "stopped"]
    assert seen["running"].title == "Live"
    assert "move, age of measurement: 0 ms" in robot[0]
    stopped = seen["stopped"]
    assert (stopped.title, stopped.text) == ("Stopped", "stop button")
    released = seen["released"]
    assert (released.title, released.buttons) == ("Live", (page_state.STOP,))
    assert released.text.startswith("moving to the target")

    trajectory = result.trajectory
    t, u = trajectory.time, trajectory.u
    assert np.abs(u[t < 1.0]).max() > 0.3
    # From the press to the standstill no longer than the ramp from full
    # speed: 0.5 m/s at 1 m/s^2.
    motion_status = (t > 1.56) & (t < 3.0)
    assert motion_status.any() and not u[motion_status].any()
    q = trajectory.q[:-1][motion_status]
    assert np.ptp(q, axis=0).max() == 0.0
    assert np.abs(u[(t > 3.0) & (t < 5.0)]).max() > 0.3
    change = np.abs(np.diff(u, axis=0)) / 0.02
    limit = application.world.robot.acceleration_limit
    assert (change <= limit * (1 + 1e-9)).all()


def test_a_release_without_a_stop_does_nothing(page, application, click):
    application.scenario.time_limit = 1.5
    _, changes = modes_of(
        application, Steps((1.0, lambda: click(page.meshcat, RELEASE)))
    )
    assert changes[-1][1] == RUNNING


def test_a_real_robots_page_has_a_stop_and_no_release(page, click):
    panel = SafetyPanel(page=page, n_u=9, releases=False)
    context = panel.CreateDefaultContext()
    with pytest.raises(RuntimeError, match="elease"):
        page.meshcat.GetButtonClicks(RELEASE)
    click(page.meshcat, RELEASE)
    click(page.meshcat, STOP)
    requests = panel.GetOutputPort("operator").Eval(context)
    assert (requests.stops, requests.releases) == (1, 0)
    stopped = SupervisorState(np.zeros(9), STOPPED, "stop button")
    page.show(page_state.supervised(stopped, releases=False))
    click(page.meshcat, RELEASE)
    assert page.clicks(page_state.RELEASE) == 0
    assert RELEASE not in page.meshcat.GetButtonNames()


@pytest.mark.slow
@pytest.mark.browser
@pytest.mark.skipif(
    find_chromium() is None, reason="needs chromium on the PATH"
)
def test_a_browser_stops_and_releases(page, application):
    """By key, by mouse, and the page says so."""
    text = "document.body.innerText"
    with open_browser((600, 400)) as tab:
        tab.open(page.url)
        tab.wait_for(f"{text}.includes('STOP')")

        def shows(words):
            return lambda: tab.wait_for(f"{text}.includes('{words}')")

        result, changes = modes_of(
            application,
            Steps(
                (0.5, shows("Live")),
                (0.5, lambda: press_escape(tab, page)),
                (2.0, shows("stop button")),
                (2.0, lambda: click_on(tab, page, "release", RELEASE)),
                (4.0, shows("Live")),
                (4.0, lambda: click_on(tab, page, "stop", STOP)),
            ),
            patience=3.0,
        )
        shows("stop button")()
        height = "querySelector('.remosplat-stop').offsetHeight"
        assert tab.evaluate(f"document.{height}") > 50
    assert result.outcome == "stopped: stop button"
    assert [m for _, m in changes].count(STOPPED) == 2
    assert not result.trajectory.u[-1].any()


def press_escape(tab, page):
    """Presses the key and waits until Meshcat has heard of it."""
    clicks = page.meshcat.GetButtonClicks(STOP)
    tab.press("Escape")
    wait_for_click(page, STOP, clicks)


def click_on(tab, page, what: str, name: str):
    """Clicks with the mouse and waits until Meshcat has heard of it."""
    clicks = page.meshcat.GetButtonClicks(name)
    tab.click(f".remosplat-{what}")
    wait_for_click(page, name, clicks)


def wait_for_click(page, name: str, before: int):
    end = time.monotonic() + PATIENCE
    while page.meshcat.GetButtonClicks(name) == before:
        assert time.monotonic() < end, "Meshcat did not hear of the click"
        time.sleep(0.02)
