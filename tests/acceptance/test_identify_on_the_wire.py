"""`remosplat identify` against `remosplat hardware-sim`, as in a lab."""

import signal
import time

import pytest
from patience import PATIENCE
from robot_process import running

from remosplat_drake.acceptance.described_robot import write_description
from remosplat_drake.acceptance.hardware_processes import free_url, robot
from remosplat_drake.acceptance.wire_tap import WireTap
from remosplat_drake.robot.robot_description import load_robot_description

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
            *("--lcm-url", url, "--output", str(path)),
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
