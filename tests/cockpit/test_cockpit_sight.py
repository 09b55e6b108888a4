"""A reach by gamepad in a real browser, from the wrist picture alone."""

import base64
import io
import re
import time

import numpy as np
import pytest

pytest.importorskip("viser")

from browser import find_chromium
from cockpit_session import insist, open_session
from cockpit_tab import CockpitTab
from patience import PATIENCE
from PIL import Image
from test_cockpit_devices import PAD, hold_button

from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.stages.teleoperation import wrist_camera_mount
from remosplat_drake.app.world import load_world
from remosplat_drake.recording.run_log import read_log
from remosplat_drake.recording.trajectory_log import LOG

READ = """(() => {
  const image = [...document.querySelectorAll('img')].find(
    (i) => i.src.startsWith('blob:') && i.complete && i.naturalWidth);
  if (!image) return '';
  const canvas = document.createElement('canvas');
  [canvas.width, canvas.height] = [image.naturalWidth, image.naturalHeight];
  canvas.getContext('2d').drawImage(image, 0, 0);
  return canvas.toDataURL().split(',')[1];
})()"""
"""The wrist picture as the page shows it."""

DEAD_MAN = load_scenario("TableTeleop").teleop.gamepad.dead_man
"""The switch that must be held."""

DOWN = 6
"""The trigger that moves the target down."""

SHIFT = 12.0
"""Shift of the can in the picture that shows a stick's direction [px]."""

CENTRED = 15.0
"""Error of the can's centre at which it counts as centred [px]."""

NEAR = 0.10
"""Distance ahead at which the reach ends [m]."""

CAN = (1.019, 0.240)
"""Where the scene's left can stands, which has a red-brown top [m]."""


@pytest.mark.slow
@pytest.mark.browser
@pytest.mark.skipif(
    find_chromium() is None, reason="needs chromium on the PATH"
)
def test_a_can_is_reached_from_the_wrist_picture_alone(tmp_path):
    session = tmp_path / "session"
    with open_session("TableTeleop", session, script=PAD) as operator:
        reach(operator)
        operator.tab.save_picture(tmp_path / "reached.png")
    rows = read_log(session / "runs" / "0001" / LOG).rows
    # The picture's middle was the can's, and the hand kept its distance.
    assert rows["clearance"].min() > 0.02
    p_WC = camera_position(rows["q"][-1])
    assert np.linalg.norm(p_WC[:2] - CAN) < 0.02


def camera_position(q: np.ndarray) -> np.ndarray:
    """Position of the wrist camera in the world, shape (3,) [m]."""
    scenario = load_scenario("TableTeleop")
    robot = load_world(scenario, blank=True).robot
    mount = wrist_camera_mount(scenario, robot)
    assert mount is not None
    return mount.pose(q)[:3, 3]


def reach(operator: CockpitTab):
    """Centres the can in the picture, and descends to it."""
    pose = "→ over the table"
    insist(operator, lambda: operator.press(pose), "0.45 m ahead")
    for _ in range(4):
        operator.key("KeyZ", "z")  # Slower, since the picture is late.
    shifts = np.transpose([shift(operator, 1, 0), shift(operator, 0, 1)])
    end = time.monotonic() + PATIENCE
    error = error_of(operator)
    while np.linalg.norm(error) > CENTRED or not is_near(operator):
        assert time.monotonic() < end, operator.text
        away, left = np.clip(np.linalg.solve(shifts, error) / 60, -1, 1)
        descends = bool(np.linalg.norm(error) < 2 * CENTRED)
        lead(operator, away, left, descends)
        error = error_of(operator)
    hold_button(operator, DEAD_MAN, 0)
    operator.wait_for_text("the dead-man button was released")


def shift(operator: CockpitTab, away: float, left: float) -> np.ndarray:
    """Direction in which the can's error falls as the stick is pushed."""
    first = error_of(operator)
    end = time.monotonic() + PATIENCE
    while np.linalg.norm(moved := first - error_of(operator)) < SHIFT:
        assert time.monotonic() < end, operator.text
        lead(operator, away, left)
    lead(operator, 0, 0)
    return moved / np.linalg.norm(moved)


def lead(operator: CockpitTab, away: float, left: float, descends=False):
    """Pushes the left stick, and the trigger down, with the switch held.

    On a busy computer the cockpit may fall silent, which stops the robot.
    """
    operator.press_any("Let the robot go", "RELEASE")
    operator.tab.evaluate(f"pad.axes = [{-left}, {-away}, 0, 0]")
    hold_button(operator, DOWN, float(descends))
    hold_button(operator, DEAD_MAN, 1)
    time.sleep(0.05)  # The page's turn.


def error_of(operator: CockpitTab) -> np.ndarray:
    """From the centre of the can's red-brown top to the crosshair [px]."""
    picture = base64.b64decode(operator.tab.wait_for(READ))
    rgb = np.array(Image.open(io.BytesIO(picture)).convert("RGB"), int)
    is_top = (rgb[..., 0] - rgb[..., 1] > 25) & (rgb[..., 0] > 90)
    v, u = np.nonzero(is_top)
    assert len(u) > 60, "the can is out of sight"
    return np.array(rgb.shape[1::-1]) / 2 - [np.median(u), np.median(v)]


def is_near(operator: CockpitTab) -> bool:
    """Whether the page's distance ahead is that of the end."""
    found = re.search(r"([0-9.]+) m ahead", operator.text)
    return found is not None and float(found[1]) < NEAR
