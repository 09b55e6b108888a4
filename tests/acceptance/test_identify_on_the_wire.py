"""`remosplat identify` against `remosplat hardware-sim`, as in a lab."""

import signal
import time

import numpy as np
import pytest
from patience import PATIENCE
from pydrake.math import RigidTransform
from robot_process import running

from remosplat_drake.acceptance.described_robot import write_description
from remosplat_drake.acceptance.hardware_processes import free_url, robot
from remosplat_drake.acceptance.wire_tap import WireTap
from remosplat_drake.app.identification.reading import await_robot
from remosplat_drake.app.identification.room import Room
from remosplat_drake.controller.verification.self_sweep import SelfClearance
from remosplat_drake.hardware.client.robot_link import RobotLink
from remosplat_drake.hardware.hardware_config import HardwareConfig
from remosplat_drake.hardware.localization_config import LocalizationConfig
from remosplat_drake.hardware.stand_in.base_senses import X_WO
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.planar_pose import composed
from remosplat_drake.robot.robot_description import load_robot_description
from remosplat_drake.scene.primitive_scene import Cylinder, PrimitiveScene

DELAY = 0.15


@pytest.mark.slow
def test_a_late_base_is_found_though_the_robot_hangs_once(
    wire, table, tmp_path
):
    url, path = free_url(), tmp_path / "robot.yaml"
    write_description(path, "frankie")
    tap = WireTap(url)
    with (
        robot(url, "--fault", f"base-command-delay={DELAY}@0") as process,
        running(
            *("identify", "TableReach", "--yes", "--axes", "0"),
            *("--lcm-url", url, "--without-doctor", "--output", str(path)),
        ) as identify,
    ):
        assert tap.wait(lambda: tap.moving_at is not None, PATIENCE)
        process.send_signal(signal.SIGSTOP)
        time.sleep(0.3)  # Longer than a status may be old.
        process.send_signal(signal.SIGCONT)
        assert identify.wait(PATIENCE) == 0, identify.stderr
    forward, *others = load_robot_description(path).actuators
    late = forward.delay + forward.time_constant
    assert late == pytest.approx(DELAY, abs=0.02)
    # What was not measured is assumed, as cautiously as before.
    assert others == table.robot.assumed_actuators[1:]


def test_a_localised_robot_is_looked_for_in_the_map(wire, table):
    config = HardwareConfig(
        lcm_url=free_url(), localization=LocalizationConfig()
    )
    with robot(config.url, "--localization"):
        link = RobotLink(config, table.robot)
        reading = await_robot(link, table.robot, config)
    np.testing.assert_allclose(
        composed(X_WO, reading.q[:3]), table.q0[:3], atol=1e-6
    )
    shift, turn = reading.measurement.base_track.uncertainty
    off = reading.q_W - table.q0
    assert np.hypot(*off[:2]) <= shift and abs(off[2]) <= turn
    own = SelfClearance.make(table.robot, 0.01)

    def problem(q: np.ndarray, pillar: float) -> str:
        """What a pillar on the x axis of the map stands in the way of."""
        place = RigidTransform([pillar, 0.0, 0.3])
        scene = PrimitiveScene(cylinders=(Cylinder(place, 0.03, 0.5),))
        room = Room(SignedDistanceField(scene), own, 0.1, 0.01)
        return room.about(reading).problem(q)

    # Odometry has the robot 0.3 m farther back.
    assert problem(reading.q_W, -0.6) == ""
    assert "the scene is" in problem(reading.q, -0.6)
    assert "the scene is" in problem(reading.q_W, 0.6)
    assert problem(reading.q, 0.6) == ""


@pytest.mark.slow
def test_a_localised_base_is_identified(wire, tmp_path):
    url, path = free_url(), tmp_path / "robot.yaml"
    write_description(path, "frankie")
    late = f"base-command-delay={DELAY}@0"
    with (
        robot(url, "--localization", "--fault", late),
        running(
            *("identify", "TableReach", "--yes", "--axes", "0"),
            *("--lcm-url", url, "--without-doctor", "--output", str(path)),
            *("--scenario-text", "{hardware: {localization: {}}}"),
        ) as identify,
    ):
        assert identify.wait(PATIENCE) == 0, identify.stderr
    forward = load_robot_description(path).actuators[0]
    assert forward.delay + forward.time_constant == pytest.approx(
        DELAY, abs=0.02
    )
