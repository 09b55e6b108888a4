"""`remosplat driver-check` beside real processes, at several rates."""

import contextlib
import json
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from effort import effort
from patience import PATIENCE
from robot_process import Client, free_address, running
from runs import PATIENT

from remosplat_drake.acceptance.consent import Consent
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
  scene:
    splat: package://remosplat_drake/models/scenes/table/splat.ply
    truth: package://remosplat_drake/models/scenes/table/scene.json
  targets:
  - {{translation: [0.5, 0.3, 0.4], rpy_deg: [180, 0, 0]}}
  time_limit: 1000
  hardware:
    arm_status_rate: {rate}
    arm_driver: {driver}
"""

DRIVERS = {
    "lcm": "null",
    "ros2": "!Ros2Arm {{domain: {domain}, emergency_stop: /e_stop}}",
    "ur": "!UrArm {{host: {address}}}",
}
"""The arm's driver, by the kind of stand-in."""


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
    if kind != "ros2":
        return lambda: client.inject("user-stop")
    from remosplat_drake.hardware.drivers import ros2_messages as ros

    node = Ros2Node(DOMAIN, "a test")
    faults = node.writer(FAULTS_TOPIC, ros.String)
    return lambda: faults.write(ros.String("user-stop"))


RATES = (20, 50, 125, 500, 1000)
"""Rates at which drivers send statuses [Hz]."""

slow_rates = pytest.mark.parametrize(
    ("kind", "rate"),
    effort(
        [("lcm", 20), ("lcm", 1000), ("ros2", 50), ("ros2", 500), ("ur", 125)],
        [*((kind, r) for kind in ("lcm", "ros2") for r in RATES), ("ur", 125)],
    ),
)
"""A Universal Robots arm has a rate of its own."""


@contextlib.contextmanager
def connected(kind: str, rate: int, folder: Path, url: str) -> Iterator[str]:
    """The file of a UR5e's scenario; its stand-in and its driver run."""
    file, address = folder / "lab.yaml", free_address()
    driver = DRIVERS[kind].format(domain=DOMAIN, address=address)
    file.write_text(SCENARIO.format(rate=rate, driver=driver))
    lines = {
        "lcm": [("hardware-sim", "--lcm-url", url)],
        "ros2": [("hardware-sim", "--ros2"), ("arm-driver", "--lcm-url", url)],
        "ur": [
            ("hardware-sim", "--lcm-url", url, "--rtde", address),
            ("arm-driver", "--lcm-url", url),
        ],
    }
    if kind != "lcm":
        needs = {"ros2": "cyclonedds", "ur": "rtde_control"}[kind]
        pytest.importorskip(needs, reason=f"needs the extra {kind}")
    with contextlib.ExitStack() as programs:
        for command, *flags in lines[kind]:
            robot = programs.enter_context(running(command, str(file), *flags))
            if command == "hardware-sim":
                # An arm's driver ends if its controller does not answer.
                assert robot.stderr is not None
                while "Ctrl-C ends" not in robot.stderr.readline():
                    assert robot.poll() is None
        yield str(file)


@pytest.mark.slow
@slow_rates
def test_stand_ins_pass_at_every_rate(kind, rate, lone_robot, tmp_path: Path):
    url = free_url()
    with (
        connected(kind, rate, tmp_path, url) as file,
        contextlib.ExitStack() as programs,
    ):
        client = Client(url)
        client.wait_for(lambda: bool(client.arm))
        check = programs.enter_context(
            running(
                *("driver-check", file, "--lcm-url", url),
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


@pytest.mark.slow
@slow_rates
def test_robots_reach_their_target_at_every_rate(
    kind, rate, lone_robot, tmp_path: Path
):
    url = free_url()
    with connected(kind, rate, tmp_path, url) as file:
        line = ("run", file, "--hardware", "--without-doctor", "--headless")
        flags = ("--lcm-url", url, "--scenario-text", PATIENT)
        with running(*line, *flags) as run:
            client, operator = Client(url), Consent(url, again=True)

            def ends() -> bool:
                operator.give()
                return run.poll() is not None

            client.wait_for(ends)
            summary, said = run.communicate()
    assert run.returncode == 0, summary + said
    assert "reached" in summary


def test_a_silent_wire_fails(tmp_path: Path, capsys):
    file = tmp_path / "lab.yaml"
    driver = DRIVERS["ros2"].format(domain=DOMAIN)
    file.write_text(SCENARIO.format(rate=50, driver=driver))
    line = ["driver-check", str(file), "--duration", "0.5"]
    assert main([*line, "--lcm-url", free_url()]) == 1
    said = capsys.readouterr().out
    assert "the check sends nothing" in said
    assert "arm: statuses: none came" in said
    assert "at 50 Hz the controller detects an arm that stops sending" in said


def test_a_duration_that_is_too_long_is_told(capsys):
    assert main(["driver-check", "Ur5eReach", "--duration", "4000"]) == 2
    assert "--duration: must be at most 3600" in capsys.readouterr().err
