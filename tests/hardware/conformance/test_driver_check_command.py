"""`remosplat driver-check` beside real processes, at several rates."""

import contextlib
import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from patience import PATIENCE
from robot_process import Client, running

from remosplat_drake.acceptance.hardware_processes import free_url
from remosplat_drake.commands.main import main
from remosplat_drake.hardware.doctor.finding import FAILED, PASSED, SKIPPED
from remosplat_drake.hardware.drivers.ros2_node import Ros2Node
from remosplat_drake.hardware.stand_in.ros2_robot import FAULTS_TOPIC
from remosplat_drake.hardware.stand_in.simulated_arm import RobotMode

DOMAIN = 86

BUSY = {"rate", "silence", "age of measurements", "latency"}
"""What fails where the computer has no time for a stand-in, and rightly so."""

SCENARIO = """
Lab:
  robot: {{model: ur5e}}
  hardware:
    arm_status_rate: {rate}
    arm_driver: !Ros2Arm {{domain: {domain}, emergency_stop: /e_stop}}
"""


def drive_all(client: Client) -> None:
    """Moves each joint forth and back by itself, as smoothly as it can."""
    client.catch_up()
    for joint in range(6):
        start, rates = client.time, np.zeros(6)

        def is_done(joint=joint, start=start, rates=rates) -> bool:
            passed = client.time - start
            rates[joint] = 0.3 * np.sin(2 * np.pi * passed)
            return passed >= 1.0

        client.drive(is_done, rates)
    client.drive(
        lambda: np.abs(client.latest.joint_velocity).max() < 1e-3, np.zeros(6)
    )


def stop_button(kind: str, client: Client) -> Callable[[], None]:
    """Returns what presses the user stop of a stand-in, on its own network."""
    if kind == "lcm":
        return lambda: client.inject("user-stop")
    from remosplat_drake.hardware.drivers import ros2_messages as ros

    node = Ros2Node(DOMAIN, "a test")
    faults = node.writer(FAULTS_TOPIC, ros.String)
    return lambda: faults.write(ros.String("user-stop"))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "rate"),
    [("lcm", 20), ("lcm", 1000), ("ros2", 50), ("ros2", 500)],
)
def test_stand_ins_pass_at_every_rate(kind, rate, tmp_path: Path):
    if kind == "ros2":
        pytest.importorskip("cyclonedds", reason="needs the extra ros2")
    file, url = tmp_path / "lab.yaml", free_url()
    file.write_text(SCENARIO.format(rate=rate, domain=DOMAIN))
    with contextlib.ExitStack() as programs:
        where = ("--ros2",) if kind == "ros2" else ("--lcm-url", url)
        programs.enter_context(running("hardware-sim", str(file), *where))
        if kind == "ros2":
            programs.enter_context(
                running("arm-driver", str(file), "--lcm-url", url)
            )
        client = Client(url)
        client.wait_for(lambda: bool(client.arm))
        check = programs.enter_context(
            running(
                *("driver-check", str(file), "--lcm-url", url),
                *("--skip", "restart", "--duration", "300", "--json"),
            )
        )
        assert check.stderr is not None
        while "listening on" not in check.stderr.readline():
            assert check.poll() is None
        drive_all(client)
        press = stop_button(kind, client)

        def is_stopped() -> bool:
            press()
            return client.latest.robot_mode == RobotMode.USER_STOPPED

        client.drive(is_stopped, np.zeros(6))
        said, _ = check.communicate(timeout=PATIENCE)
    found = {f["check"]: f["result"] for f in json.loads(said)}
    wrong = {check for check, result in found.items() if result == FAILED}
    skipped = {check for check, result in found.items() if result == SKIPPED}
    assert skipped == {"restart"}, said
    assert check.returncode == bool(wrong)
    assert not {check.rpartition(": ")[2] for check in wrong} - BUSY, said
    assert found["arm: mode and emergency stop"] == PASSED
    assert found["arm: elbow_joint"] == PASSED
    assert found["arm: elbow_joint: velocity"] == PASSED


def test_a_silent_wire_fails(tmp_path: Path, capsys):
    file = tmp_path / "lab.yaml"
    file.write_text(SCENARIO.format(rate=50, domain=DOMAIN))
    line = ["driver-check", str(file), "--duration", "0.5"]
    assert main([*line, "--lcm-url", free_url()]) == 1
    said = capsys.readouterr().out
    assert "the check sends nothing" in said
    assert "arm: statuses: none came" in said
    assert "at 50 Hz an arm that stops sending is detected 19 ms later" in said


def test_a_duration_that_is_too_long_is_told(capsys):
    assert main(["driver-check", "Ur5eReach", "--duration", "4000"]) == 2
    assert "--duration: must be at most 3600" in capsys.readouterr().err
