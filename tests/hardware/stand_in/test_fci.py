"""The stand-in's Franka Control Interface, a millisecond at a time."""

import math
import socket
import threading

import numpy as np
import pytest

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.hardware.drivers.panda_limits import (
    AT_REST,
    PANDA,
    POSITION_LOWER,
    POSITION_UPPER,
    TICK,
    limit_rate,
)
from remosplat_drake.hardware.stand_in import fci_library
from remosplat_drake.hardware.stand_in.fci_arm import FciArm
from remosplat_drake.hardware.stand_in.fci_packets import Kind, Request, State
from remosplat_drake.hardware.stand_in.fci_rules import FciRules
from remosplat_drake.hardware.stand_in.simulated_arm import (
    ArmMeasurement,
    RobotMode,
)

MIDDLE = (POSITION_LOWER + POSITION_UPPER) / 2
ZERO = np.zeros(7)
RATES = np.array([0.2, 0.1, -0.1, 0.2, 0.0, 0.3, -0.2])
SHARE = PANDA.jerk * TICK**2  # The largest first step from rest.


def measured(position=MIDDLE, external=ZERO) -> ArmMeasurement:
    return ArmMeasurement(position, ZERO, ZERO, external)


def moving(velocity: np.ndarray = RATES) -> FciRules:
    """An arm that moves evenly."""
    rules, command = FciRules(), AT_REST
    rules.begin()
    for _ in range(400):
        command = limit_rate(velocity, command)
        rules.step(measured(), command.velocity)
    assert rules.mode == RobotMode.MOVE
    return rules


def test_an_idle_arm_takes_no_command():
    rules = FciRules()
    assert not rules.step(measured(), RATES).velocity.any()
    assert (rules.mode, rules.success_rate) == (RobotMode.IDLE, 0.0)


def test_a_command_within_the_limits_is_taken_as_it_is():
    rules = moving()
    step = 0.9 * SHARE
    assert rules.step(measured(), RATES + step).velocity == pytest.approx(
        RATES + step
    )
    assert rules.success_rate == 1.0


@pytest.mark.parametrize(
    ("step", "error"),
    [
        (1.1 * SHARE, "joint_motion_generator_acceleration_discontinuity"),
        (
            1.1 * PANDA.acceleration * TICK,
            "joint_motion_generator_velocity_discontinuity",
        ),
        (
            2.0 * PANDA.velocity,
            "joint_motion_generator_velocity_limits_violation",
        ),
    ],
)
@pytest.mark.parametrize("joint", range(7))
def test_a_step_beyond_a_limit_aborts_by_its_name(step, error, joint):
    rules = moving()
    wanted = RATES.copy()
    wanted[joint] += step[joint]
    rules.step(measured(), wanted)
    assert (rules.mode, rules.error) == (RobotMode.REFLEX, error)
    for _ in range(400):
        rules.step(measured(), wanted)
    assert not np.abs(rules.command.velocity).max() > 1e-6
    rules.recover()
    assert rules.mode == RobotMode.IDLE


def test_a_joint_at_its_end_may_not_go_on():
    position = MIDDLE.copy()
    position[1] = POSITION_UPPER[1] + 1e-3
    rules = moving()
    rules.step(measured(position), RATES)
    assert rules.error == "joint_motion_generator_position_limits_violation"
    rules = moving(-RATES)
    rules.step(measured(position), -RATES)
    assert rules.error == ""


def test_a_collision_is_what_the_driver_has_set():
    touch = np.array([0.0, 0.0, 0.0, 15.0, 0.0, 0.0, 0.0])
    rules = moving()
    rules.step(measured(external=touch), RATES)
    assert rules.error == ""
    rules.collision_torque = np.full(7, 14.0)
    rules.step(measured(external=touch), RATES)
    assert rules.error == "joint_reflex"


def test_a_motion_ends_at_rest_only():
    rules = moving()
    rules.step(measured(), RATES, is_last=True)
    assert rules.error == "joint_motion_generator_velocity_discontinuity"
    rules = FciRules()
    rules.begin()
    rules.step(measured(), ZERO, is_last=True)
    assert (rules.mode, rules.error) == (RobotMode.IDLE, "")


def test_lost_packets_are_made_up_for_at_constant_acceleration():
    rules, command = FciRules(), AT_REST
    rules.begin()
    for _ in range(20):
        command = limit_rate(np.ones(7), command)
        rules.step(measured(), command.velocity)
    for n in range(1, 4):
        made_up = rules.step(measured(), None)
        np.testing.assert_allclose(
            made_up.velocity,
            command.velocity + n * TICK * command.acceleration,
        )
    assert rules.success_rate == pytest.approx(21 / 24)


# Packets


class Client:
    """A client whose every packet is written by hand."""

    def __init__(self, arm: FciArm):
        self._arm = arm
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.connect(("127.0.0.1", arm.port))

    def send(self, kind: Kind, number=0, values=()) -> None:
        self._socket.send(Request(kind, number, tuple(values)).encode())

    def step(self) -> State | None:
        """A millisecond of the arm, and what it sends."""
        self._arm.step(measured())
        try:
            return State.decode(self._socket.recv(1024, socket.MSG_DONTWAIT))
        except BlockingIOError:
            return None

    def begin(self) -> State:
        self.send(Kind.BEGIN)
        state = self.step()
        assert state is not None
        return state

    def close(self) -> None:
        self._socket.close()


@pytest.fixture
def arm():
    arm = FciArm()
    yield arm
    arm.close()


@pytest.fixture
def client(arm):
    client = Client(arm)
    yield client
    client.close()


def test_only_who_asks_gets_a_state(arm, client):
    assert client.step() is None
    client.send(Kind.READ)
    state = client.step()
    assert state.mode == RobotMode.IDLE
    np.testing.assert_allclose(state.vectors[:7], MIDDLE)


def test_an_answer_counts_only_for_the_state_that_came_last(arm, client):
    state = client.begin()
    assert state.mode == RobotMode.MOVE
    client.send(Kind.COMMAND, state.number, 0.5 * SHARE)
    state = client.step()
    np.testing.assert_allclose(state.vectors[21:28], 0.5 * SHARE)
    client.send(Kind.COMMAND, state.number - 1, ZERO)
    assert client.step().success_rate < 1.0


def test_a_second_client_is_not_obeyed(arm, client):
    state = client.begin()
    other = Client(arm)
    other.send(Kind.COMMAND, state.number, 0.5 * SHARE)
    client.send(Kind.COMMAND, state.number, ZERO)
    assert not any(client.step().vectors[21:28])
    other.send(Kind.BEGIN)
    assert client.step() is not None
    other.close()


def test_a_client_that_moves_the_arm_is_told_why_it_stops(arm, client):
    client.begin()
    arm.stop(RobotMode.USER_STOPPED)
    assert client.step().mode == RobotMode.USER_STOPPED
    assert client.step() is None
    arm.recover()
    assert client.begin().mode == RobotMode.MOVE


def test_twenty_silent_milliseconds_abort(arm, client):
    client.begin()
    states = [client.step() for _ in range(20)]
    assert states[18].mode == RobotMode.MOVE
    assert states[19].mode == RobotMode.REFLEX
    assert states[19].error == "communication_constraints_violation"


@pytest.mark.parametrize("data", [b"", b"garbage", bytes(1000)])
def test_what_is_no_request_is_left_out(arm, client, data):
    client._socket.send(data)
    assert client.begin().mode == RobotMode.MOVE


def test_a_port_that_is_taken_is_told_in_one_line(arm):
    with pytest.raises(RemoSplatError, match=f"UDP port {arm.port}: "):
        FciArm(arm.port)


# The library


@pytest.fixture
def robot(arm):
    """Libfranka's side, while the arm's milliseconds pass by themselves."""
    over = threading.Event()

    def run() -> None:
        while not over.wait(2e-3):
            arm.step(measured())

    thread = threading.Thread(target=run)
    thread.start()
    yield fci_library.Robot(str(arm.port))
    over.set()
    thread.join()


def rest(last: bool):
    return fci_library.JointVelocities([0.0] * 7, last)


def test_a_callback_answers_every_state(arm, robot):
    periods = []

    def callback(state, period):
        periods.append(period.to_msec())
        assert state.robot_mode == fci_library.RobotMode.kMove
        return rest(len(periods) == 20)

    robot.control_joint_velocity(callback)
    assert periods[0] == 0
    assert min(periods[1:]) == 1
    assert robot.read_once().robot_mode == fci_library.RobotMode.kIdle


def test_an_abort_is_an_error_with_its_name(arm, robot):
    def callback(state, period):
        return fci_library.JointVelocities([1.0] * 7)

    with pytest.raises(RuntimeError, match="velocity_discontinuity"):
        robot.control_joint_velocity(callback)
    with pytest.raises(RuntimeError, match="reflex"):
        robot.control_joint_velocity(lambda state, period: rest(True))


def test_rates_that_are_no_numbers_never_reach_the_robot(arm, robot):
    def callback(state, period):
        return fci_library.JointVelocities([math.nan] * 7)

    with pytest.raises(ValueError, match="NaN"):
        robot.control_joint_velocity(callback)


def test_limits_reach_the_robot(arm, robot):
    limits = list(range(7))
    robot.set_collision_behavior(limits, limits, [0.0] * 6, [0.0] * 6)
    np.testing.assert_allclose(arm.rules.collision_torque, limits)


def test_a_missing_robot_is_an_error():
    with pytest.raises(RuntimeError, match="libfranka: UDP"):
        fci_library.Robot("1").read_once()
