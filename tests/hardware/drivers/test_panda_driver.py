"""The driver on panda-python: all of it but the arm itself."""

from types import SimpleNamespace as Fields

import numpy as np
import pytest
from pydrake.lcm import DrakeLcm
from robot_process import Client

from remosplat_drake.acceptance.hardware_processes import free_url
from remosplat_drake.commands.main import main
from remosplat_drake.hardware.drivers.panda_commands import CommandError
from remosplat_drake.hardware.drivers.panda_driver import (
    PandaDriver,
    panda_status,
)
from remosplat_drake.hardware.drivers.panda_limits import TICK, JointCommand

panda_py = pytest.importorskip("panda_py", reason="needs the extra panda")
controllers = pytest.importorskip("panda_py.controllers")

NOW = 1_700_000_000_000_000
RATES = np.array([0.1, 0.0, -0.2, 0.0, 0.0, 0.3, 0.0])


class IntegratingArm:
    """Seven joints that do at once what they are told."""

    def __init__(self):
        self.q, self.dq, self.ticks = np.zeros(7), np.zeros(7), 0

    def set_velocity(self, velocity: np.ndarray) -> None:
        self.dq = velocity
        self.q = self.q + TICK * velocity
        self.ticks += 1

    def problem(self) -> str:
        return ""

    def state(self):
        milliseconds = self.ticks
        return Fields(
            q=self.q,
            q_d=self.q,
            dq=self.dq,
            tau_J=np.full(7, 1.0),
            tau_J_d=np.full(7, 2.0),
            tau_ext_hat_filtered=np.full(7, 3.0),
            control_command_success_rate=0.99,
            robot_mode=panda_py.libfranka.RobotMode.kMove,
            time=Fields(to_msec=lambda: milliseconds),
        )


def test_a_status_holds_the_robots_state():
    command = JointCommand(RATES, 10 * RATES)
    arm = IntegratingArm()
    arm.set_velocity(RATES)
    status = panda_status(arm.state(), command, 123)
    assert type(status).decode(status.encode()).utime == 123
    assert (status.robot_mode, status.robot_utime) == (2, 1000)
    assert status.control_command_success_rate == 0.99
    np.testing.assert_allclose(status.joint_position, 1e-3 * RATES)
    np.testing.assert_allclose(status.joint_velocity, RATES)
    np.testing.assert_allclose(status.joint_velocity_desired, RATES)
    np.testing.assert_allclose(status.joint_acceleration_desired, 10 * RATES)
    assert status.joint_torque_external == [3.0] * 7


def test_a_robot_state_has_all_that_a_status_needs():
    fields = vars(IntegratingArm().state())
    assert fields.keys() <= set(dir(panda_py.libfranka.RobotState))
    assert hasattr(panda_py.libfranka.Duration, "to_msec")


def test_the_package_has_all_that_the_arm_needs():
    for name in ("get_robot", "get_state", "raise_error", "stop_controller"):
        assert hasattr(panda_py.Panda, name)
    controller = controllers.IntegratedVelocity()
    controller.set_control(RATES)


class Wire:
    """A driver, its arm and somebody who commands.

    Time stands still, so that no command grows old on its way.
    """

    def __init__(self):
        url = free_url()
        self.arm, self.client = IntegratingArm(), Client(url, lambda: NOW)
        self.driver = PandaDriver(DrakeLcm(url), self.arm)

    def drive_until(self, done, velocity: np.ndarray) -> None:
        """Repeats a command until something is so."""

        def step() -> bool:
            self.client.send_arm(velocity)
            self.driver.step(NOW)
            return done()

        self.client.wait_for(step)


def test_an_arm_is_driven_over_the_wire():
    wire = Wire()
    statuses = wire.client.arm
    wire.drive_until(
        lambda: (
            statuses
            and np.allclose(statuses[-1].joint_velocity, RATES, atol=1e-2)
        ),
        RATES,
    )
    # Without commands: half a second later by the driver's clock.
    for _ in range(100):
        wire.driver.step(NOW + 500_000)
    assert np.abs(wire.arm.dq).max() < 1e-3


def test_what_is_no_command_ends_the_driver_after_a_ramp():
    wire = Wire()
    arm = wire.arm
    wire.drive_until(lambda: np.abs(arm.dq).max() > 0.29, RATES)
    with pytest.raises(CommandError):
        wire.drive_until(lambda: False, RATES[:6])
    speeds = [np.abs(arm.dq).max()]
    while not wire.driver.brake():
        speeds.append(np.abs(arm.dq).max())
    assert speeds[0] > 0.25
    assert len(speeds) > 20
    assert np.abs(arm.dq).max() < 1e-4


@pytest.mark.parametrize(
    "arguments",
    [("127.0.0.1",), ("127.0.0.1", "--hand"), ("no.such.host.invalid",)],
)
def test_a_wrong_host_is_told_in_one_line(arguments, capsys):
    assert main(["panda-driver", *arguments]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "no Panda answers" in line
    assert arguments[0] in line
