"""A wrist camera is calibrated while a person moves the robot: on the wire."""

import contextlib
import re

import numpy as np
import pytest
from patience import PATIENCE
from pydrake.lcm import DrakeLcm
from robot_process import Client, robot_process, running

from remosplat_drake.acceptance.hardware_processes import free_url
from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.hardware.hardware_config import beside
from remosplat_drake.hardware.wire import channels
from remosplat_drake.hardware.wire.inbox import Inbox

SCENARIO = """
Kitchen:
  scene: {{truth: package://remosplat_drake/models/scenes/studio/scene.json}}
  wrist_camera: {{width: 160, height: 120{mount}}}
"""
BELIEVED = ", translation: [0.008, 0.0, -0.006], rpy_deg: [1.5, -1.0, 1.0]"
"""Where the camera is not: 10 mm and 2 degrees off."""

TURNS = np.radians(
    [
        [0, 0, 0, 0, 0, 0, 0],
        [0, 0, 0, 0, 0, -12, 0],
        [0, 0, 0, 0, 12, -12, 0],
        [0, 0, 0, 0, 12, 0, 14],
        [0, 0, 0, 0, -12, 0, 14],
        [0, 0, 0, 0, -12, 10, -14],
        [10, 0, 0, 0, 0, 10, -14],
        [10, 0, 0, -10, 0, -10, 0],
    ]
)
"""Joints of the arm at each place, less those of the start [rad]."""


def go(client: Client, q: np.ndarray) -> None:
    """Drives the arm to a configuration, and lets it stand."""

    def rates() -> np.ndarray:
        return np.clip(2 * (q - client.latest.joint_position), -0.5, 0.5)

    while np.abs(rates()).max() > 2e-3:
        heard = len(client.arm)
        client.drive(lambda n=heard: len(client.arm) > n + 20, arm=rates())
    client.listen_for(0.5)


@pytest.mark.slow
def test_the_mount_is_found_while_the_robot_moves(
    lone_robot, rendering, tmp_path
):
    url = free_url()
    true, believed = tmp_path / "true.yaml", tmp_path / "believed.yaml"
    true.write_text(SCENARIO.format(mount=""))
    believed.write_text(SCENARIO.format(mount=BELIEVED))
    flags = "--lcm-url", url
    images = Inbox(DrakeLcm(beside(url)), [channels.WRIST_CAMERA])
    with contextlib.ExitStack() as lab:
        lab.enter_context(robot_process(url, "TableReach"))
        camera = "camera-sim", true, *flags, "--rate", "10"
        lab.enter_context(running(*camera))
        client = Client(url)
        client.wait_for_robot()
        client.wait_for(lambda: any(images.fetch()))
        calibration = lab.enter_context(
            running(
                *("calibrate-hand-eye", believed, *flags, "--write"),
                *("--frames", str(len(TURNS))),
            )
        )
        start = np.array(client.latest.joint_position)
        assert calibration.stdout is not None
        for i, turn in enumerate(TURNS):
            go(client, start + turn)
            for line in calibration.stdout:
                if line.startswith(f"{i + 1} of"):
                    break
        said, complaint = calibration.communicate(timeout=PATIENCE)
    assert calibration.returncode == 0, complaint
    found = load_scenario(str(believed)).camera
    assert found is not None
    X = found.hand_eye()
    assert np.linalg.norm(X.translation()) < 1e-3
    assert X.rotation().ToAngleAxis().angle() < np.radians(0.1)
    off = re.search(r"wrong by ([\d.]+) deg and ([\d.]+) mm", said)
    assert off and abs(float(off[1]) - 2.1) < 0.2, said
