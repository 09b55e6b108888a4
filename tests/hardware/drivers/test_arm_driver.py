"""Any arm behind the wire: Universal Robots' RTDE and ros2_control, for real.

The processes are the driver's and the robot's; ur_rtde itself speaks to the
stand-in of the controller.
"""

import contextlib
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from patience import PATIENCE
from pydrake.lcm import DrakeLcm
from robot_process import Client, free_address, running

from remosplat_drake.acceptance.hardware_processes import free_url
from remosplat_drake.commands.main import main
from remosplat_drake.hardware.drivers.arm_driver import ArmDriver, ArmReport
from remosplat_drake.hardware.stand_in.simulated_arm import RobotMode

RATES = np.array([0.2, 0.0, 0.0, 0.1, 0.0, -0.3])
NOW = 1_700_000_000_000_000


class Arm:
    """An arm that obeys at once."""

    def __init__(self):
        self.asked: list[np.ndarray] = []
        self.report = ArmReport(np.zeros(6), np.zeros(6), 2.0)

    def command(self, velocity: np.ndarray) -> None:
        self.asked.append(velocity)
        self.report = ArmReport(np.zeros(6), velocity, 2.0)

    def fetch(self) -> ArmReport:
        return self.report

    def close(self) -> None:
        pass


def test_commands_expire_and_statuses_tell_what_the_arm_does():
    wire, arm = DrakeLcm("memq://"), Arm()
    client = Client(wire, lambda: NOW)
    driver = ArmDriver(wire, arm, joints=6)
    driver.step(NOW, 0.0)
    assert not arm.asked, "nothing is asked before a command comes"
    client.send_arm(RATES)
    driver.step(NOW, 0.01)
    np.testing.assert_array_equal(arm.asked[-1], RATES)
    driver.step(NOW + 200_000, 0.015)
    assert len(arm.asked) == 1, "a dialogue takes a while"
    driver.step(NOW + 200_000, 0.02)
    assert not arm.asked[-1].any()
    client.listen()
    np.testing.assert_array_equal(client.arm[1].joint_velocity, RATES)
    assert client.latest.robot_mode == RobotMode.MOVE
    assert client.time == 2.0
    client.send_arm(np.ones(7))
    driver.step(NOW, 0.03)
    assert not arm.asked[-1].any(), "seven rates are no command to six joints"


@pytest.mark.parametrize(
    ("robot", "driver", "message"),
    [
        ("ur5e", "null", "hardware.arm_driver: is absent: name the arm's"),
        ("panda", "!UrArm {host: h}", "panda has 7 joints, a Universal"),
        ("ur5", "!UrArm {host: h}", "did you mean 'ur5e'"),
        ("ur5e", "!UrArm {host: ''}", "arm_driver.host: must"),
        ("ur5e", "!Ur {}", "unknown tag 'Ur'"),
        ("ur5e", "!nowhere:Arm {}", "cannot import nowhere"),
        (
            "ur5e",
            "!Ros2Arm {mode: /m}",
            "running_modes: set both this field and `mode`",
        ),
        (
            "ur5e",
            "!Ros2Arm {running_modes: [RUNNING]}",
            "running_modes: set both this field and `mode`",
        ),
        (
            "ur5e",
            "!Ros2Arm {mode: /m, mode_type: Int32, running_modes: ['7.0']}",
            "'7.0': an Int32 is a whole number",
        ),
        (
            "ur5e",
            "!Ros2Arm {mode: /m, mode_type: Bool, running_modes: ['yes']}",
            "'yes': a Bool is true or false",
        ),
        ("ur5e", "!Ros2Arm {stop_expiry: 0}", "stop_expiry: must"),
        (
            "ur5e",
            "!Ros2Arm {controllers: [{joints: [wrist_4_joint]}]}",
            "unknown joint 'wrist_4_joint'",
        ),
        (
            "ur5e",
            "!Ros2Arm {controllers: [{joints: [elbow_joint]}]}",
            "shoulder_pan_joint of ur5e has no controller",
        ),
        (
            "ur5e",
            "!Ros2Arm {controllers: [{}, {joints: [elbow_joint]}]}",
            "elbow_joint of ur5e has 2 controllers",
        ),
    ],
)
def test_what_makes_no_sense_is_told_in_one_line(
    robot, driver, message, capsys
):
    text = f"{{robot: {{model: {robot}}}, hardware: {{arm_driver: {driver}}}}}"
    line = ["arm-driver", "Ur5eReach", "--scenario-text", text]
    assert main([*line, "--lcm-url", free_url()]) == 2
    (said,) = capsys.readouterr().err.splitlines()[-1:]
    assert message in said


ROBOT = Path(__file__).with_name("rtde_robot.py")


@contextlib.contextmanager
def controller(record: Path) -> Iterator[tuple[str, subprocess.Popen[str]]]:
    """A controller on an address of this computer that no other has."""
    address = free_address()
    command = [sys.executable, str(ROBOT), address, str(record)]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        try:
            yield address, process
        finally:
            process.terminate()


@pytest.mark.slow
@pytest.mark.parametrize("end", ["protective stop", "silence", "killed"])
def test_a_universal_robots_arm_is_driven_and_always_comes_to_rest(
    tmp_path, end
):
    pytest.importorskip("rtde_control", reason="needs the extra ur")
    url, record = free_url(), tmp_path / "motion.npy"
    with controller(record) as (address, robot):
        arm = f"arm_status_rate: 125, arm_driver: !UrArm {{host: {address}}}"
        with running(
            *(
                "arm-driver",
                "Ur5eReach",
                "--scenario-text",
                f"{{hardware: {{{arm}}}}}",
            ),
            *("--lcm-url", url),
        ) as driver:
            client = Client(url)
            client.wait_for(lambda: bool(client.arm))
            start = np.array(client.latest.joint_position)

            def moves() -> bool:
                assert driver.poll() is None
                way = np.array(client.latest.joint_position) - start
                return way[0] > 0.1

            client.drive(moves, RATES)
            way = np.array(client.latest.joint_position) - start
            np.testing.assert_allclose(way / way[0], RATES / 0.2, atol=0.05)
            if end == "protective stop":
                robot.send_signal(signal.SIGUSR1)
                client.wait_for(
                    lambda: client.latest.robot_mode == RobotMode.REFLEX
                )
                assert driver.wait(PATIENCE) == 2
                assert driver.stderr is not None
                assert "protective stop" in driver.stderr.read()
            elif end == "silence":
                client.wait_for(
                    lambda: np.abs(client.latest.joint_velocity).max() < 1e-3
                )
                driver.terminate()
                assert driver.wait(PATIENCE) == 0
            else:
                driver.kill()
            assert robot.stdout is not None
            assert robot.stdout.readline() == "rests\n"
        robot.terminate()
        assert robot.wait(PATIENCE) == 0
    motion = np.load(record)
    assert np.abs(motion[:, 8:]).max() > 0.29
    assert not motion[-1, 8:].any()
