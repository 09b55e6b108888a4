"""The arm's driver: every part of it on the stand-in's FCI."""

import contextlib
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from fci_robot import Q_START
from patience import PATIENCE
from robot_process import Client, running

from remosplat_drake.acceptance.hardware_processes import (
    callback_of,
    free_port,
    free_url,
)
from remosplat_drake.commands.main import main
from remosplat_drake.hardware.drivers.arm_record import (
    RECORD_SIZE,
    arm_record,
    panda_status,
)
from remosplat_drake.hardware.drivers.franka_arm import LIBFRANKA
from remosplat_drake.hardware.drivers.panda_limits import JointCommand
from remosplat_drake.hardware.stand_in import fci_library
from remosplat_drake.hardware.stand_in.simulated_arm import RobotMode

pytest.importorskip("ruckig", reason="needs the extra panda")
libfranka = pytest.importorskip(LIBFRANKA)

ATTEMPTS = 5
LONGEST = 0.15
"""Time at full rate that no stop may be worth: 50 ms until a setpoint is old,
or 20 ms of lost packets, and a ramp [s]."""
RATES = np.array([0.4, -0.2, 0.2, 0.1, 0.0, 0.2, 0.3])


# What the real library has


@pytest.mark.parametrize(
    "name",
    [
        "ControllerMode",
        "Duration",
        "JointVelocities",
        "RealtimeConfig",
        "Robot",
        "RobotMode",
        "RobotState",
    ],
)
def test_the_stand_ins_library_has_nothing_that_libfranka_has_not(name):
    ours, theirs = getattr(fci_library, name), getattr(libfranka, name)
    mine = set(vars(ours)) | set(getattr(ours, "__dataclass_fields__", ()))
    public = {n for n in mine if not n.startswith("_")} - {"milliseconds"}
    assert public <= set(dir(theirs))


def test_libfranka_takes_the_arguments_that_the_driver_gives():
    """Its docstrings hold the signatures."""
    theirs = libfranka.Robot.control_joint_velocity.__doc__
    for argument in (
        "motion_generator_callback",
        "controller_mode",
        "limit_rate: bool",
        "cutoff_frequency",
    ):
        assert argument in theirs
    answer = libfranka.JointVelocities(RATES.tolist())
    answer.motion_finished = True
    assert answer.dq == RATES.tolist()
    with pytest.raises(RuntimeError):
        libfranka.Robot("127.0.0.1", libfranka.RealtimeConfig.kIgnore)


def test_a_status_holds_the_robots_state():
    vectors = np.arange(56.0).reshape(8, 7)
    state = fci_library.RobotState(
        *vectors.tolist(),
        robot_mode=fci_library.RobotMode.kMove,
        control_command_success_rate=0.99,
        time=fci_library.Duration(12),
    )
    now = 1_700_000_000_123_456
    record = arm_record(state, JointCommand(RATES, 10 * RATES), now)
    assert len(record) == RECORD_SIZE
    status = panda_status(record)
    assert type(status).decode(status.encode()).utime == now
    assert (status.robot_mode, status.robot_utime) == (2, 12_000)
    assert status.control_command_success_rate == 0.99
    np.testing.assert_allclose(status.joint_position, state.q)
    np.testing.assert_allclose(status.joint_position_desired, state.q_d)
    np.testing.assert_allclose(status.joint_velocity, state.dq)
    np.testing.assert_allclose(status.joint_torque, state.tau_J)
    np.testing.assert_allclose(status.joint_torque_desired, state.tau_J_d)
    np.testing.assert_allclose(
        status.joint_torque_external, state.tau_ext_hat_filtered
    )
    np.testing.assert_allclose(status.joint_velocity_desired, RATES)
    np.testing.assert_allclose(status.joint_acceleration_desired, 10 * RATES)


# Processes


class Rig:
    """A robot, its driver, and a controller that commands: three processes."""

    def __init__(self, folder: Path, stack: contextlib.ExitStack, *flags: str):
        self.url, self.port = free_url(), free_port()
        self._record = folder / "motion.npy"
        program = Path(__file__).with_name("fci_robot.py")
        line = [sys.executable, program, str(self.port), self._record]
        self._robot = stack.enter_context(
            subprocess.Popen(line, stdout=subprocess.PIPE)
        )
        stack.callback(self._robot.kill)
        assert self._robot.stdout
        assert self._robot.stdout.readline() == b"ready\n"
        self.driver = stack.enter_context(
            running(
                "panda-driver",
                str(self.port),
                "--simulated",
                "--lcm-url",
                self.url,
                *flags,
            )
        )
        stack.callback(self.driver.kill)
        self.client = Client(self.url)

    def drive(self) -> bool:
        """Has the arm move at `RATES`; tells whether it does.

        A machine that is busy for 20 ms loses as many packets.
        """
        client = self.client

        def over() -> bool:
            if client.arm and np.allclose(client.latest.joint_velocity, RATES):
                return True
            return self.driver.poll() is not None

        client.drive(over, RATES)
        return self.driver.poll() is None

    def press_user_stop(self) -> None:
        self._robot.send_signal(signal.SIGUSR1)

    def motion(self) -> np.ndarray:
        """Time, mode, positions and rates, shape (n, 16); ends the robot."""
        self._robot.send_signal(signal.SIGINT)
        self._robot.wait(PATIENCE)
        return np.load(self._record)


@pytest.fixture
def rig(lone_robot, tmp_path) -> Iterator[Rig]:
    """A rig whose arm moves."""
    for _ in range(ATTEMPTS):
        with contextlib.ExitStack() as stack:
            rig = Rig(tmp_path, stack)
            if rig.drive():
                yield rig
                return
    pytest.fail("this machine loses too many packets")


def travel(motion: np.ndarray, since: float) -> np.ndarray:
    """How far each joint goes after an event until the end [rad]."""
    i = int(np.searchsorted(motion[:, 0], since))
    assert np.abs(motion[i, 9:]).max() > 0.1
    assert not np.abs(motion[-1, 9:]).max() > 1e-6
    return np.abs(motion[-1, 2:9] - motion[i, 2:9])


@pytest.mark.slow
def test_ctrl_c_brings_the_arm_to_rest_and_ends_the_motion(rig):
    rig.driver.send_signal(signal.SIGINT)
    assert rig.driver.wait(PATIENCE) == 0
    motion = rig.motion()
    assert motion[-1, 1] == RobotMode.IDLE
    assert not motion[-1, 9:].any()
    assert np.abs(motion[-1, 2:9] - Q_START).max() > 0.01


@pytest.mark.slow
@pytest.mark.parametrize("way", [signal.SIGKILL, signal.SIGSTOP])
def test_without_its_driver_the_callback_ramps_to_zero(rig, way):
    """The robot aborts nothing: the callback ends the motion itself."""
    callback = callback_of(rig.driver)
    began = time.time()
    rig.driver.send_signal(way)
    while _is_alive(callback):
        assert time.time() < began + PATIENCE
        time.sleep(0.05)
    motion = rig.motion()
    assert motion[-1, 1] == RobotMode.IDLE
    assert (travel(motion, began) < LONGEST * np.abs(RATES) + 1e-3).all()


@pytest.mark.slow
def test_a_stalled_callback_ends_in_the_robots_own_abort(rig):
    began = time.time()
    os.kill(callback_of(rig.driver), signal.SIGSTOP)
    assert rig.driver.wait(PATIENCE) == 2
    assert "lost packets" in rig.driver.stderr.read()
    motion = rig.motion()
    assert motion[-1, 1] == RobotMode.REFLEX
    assert (travel(motion, began) < LONGEST * np.abs(RATES) + 1e-3).all()


@pytest.mark.slow
def test_the_last_statuses_tell_of_a_user_stop(rig):
    rig.press_user_stop()
    rig.client.wait_for(
        lambda: rig.client.latest.robot_mode == RobotMode.USER_STOPPED
    )
    assert rig.driver.wait(PATIENCE) == 2
    assert "User Stop pressed" in rig.driver.stderr.read()


@pytest.mark.slow
def test_a_driver_that_only_watches_sees_every_mode(lone_robot, tmp_path):
    with contextlib.ExitStack() as stack:
        rig = Rig(tmp_path, stack, "--status-only")
        client = rig.client
        client.wait_for(lambda: client.latest.robot_mode == RobotMode.IDLE)
        rig.press_user_stop()
        client.wait_for(
            lambda: client.latest.robot_mode == RobotMode.USER_STOPPED
        )


def _is_alive(pid: int) -> bool:
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2]
    except FileNotFoundError:
        return False
    return state.split()[0] not in "ZX"


# Mistakes


@pytest.mark.parametrize(
    "arguments",
    [("127.0.0.1",), ("127.0.0.1", "--hand"), ("no.such.host.invalid",)],
)
def test_a_wrong_host_is_told_in_one_line(arguments, capsys):
    assert main(["panda-driver", *arguments]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "no Panda answers" in line
    assert arguments[0] in line
