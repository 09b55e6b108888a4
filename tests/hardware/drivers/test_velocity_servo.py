"""The 1 kHz law: within the robot's limits for any setpoint."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from remosplat_drake.hardware.drivers.panda_limits import (
    AT_REST,
    LIMITER,
    PANDA,
    TICK,
    JointCommand,
    next_command,
    violation,
)
from remosplat_drake.hardware.stand_in.fci_rules import FciRules
from remosplat_drake.hardware.stand_in.simulated_arm import (
    ArmMeasurement,
    RobotMode,
)

pytest.importorskip("ruckig", reason="needs the extra panda")

from remosplat_drake.hardware.drivers.velocity_servo import (
    SETPOINT_EXPIRY,
    VelocityServo,
)

RATES = np.array([0.5, -0.4, 0.3, 0.2, -0.5, 0.6, 0.7])
NOWHERE = ArmMeasurement(
    np.array([0.0, -0.6, 0.0, -2.2, 0.0, 1.6, 0.8]), *np.zeros((3, 7))
)


def run(servo: VelocityServo, setpoint, ticks: int, age=0.0) -> np.ndarray:
    """Joint rates tick by tick, shape (ticks, 7) [rad/s]."""
    return np.array([servo.step(setpoint, age).velocity for _ in range(ticks)])


rate = st.one_of(
    st.floats(-3, 3),
    st.just(0.0),
    st.sampled_from([math.nan, math.inf, 1e300]),
)
phases = st.lists(
    st.tuples(
        st.lists(rate, min_size=7, max_size=7),
        st.sampled_from([0.0, 0.04, 0.06, -0.06, math.nan, math.inf]),
        st.integers(1, 40),
        st.integers(0, 19),
    ),
    min_size=1,
    max_size=8,
)


@settings(max_examples=30)
@given(phases=phases)
def test_the_robot_takes_every_command_until_it_ends(phases):
    """Jumps, old setpoints, what is not a number, lost packets: no abort.

    Extrapolation over many lost packets may itself leave the limits on
    velocity; the driver is not asked then.
    """
    servo, robot = VelocityServo(), FciRules()
    robot.begin()
    for setpoint, age, ticks, lost in phases:
        for _ in range(ticks):
            robot.step(NOWHERE, servo.step(setpoint, age).velocity)
            assert robot.error == ""
        for _ in range(lost):
            robot.step(NOWHERE, None)
        if robot.error:
            assert "velocity_limits" in robot.error
            return
        if lost:
            command = robot.command
            servo.resume(command.velocity, command.acceleration)
    for _ in range(500):
        robot.step(NOWHERE, servo.step(np.zeros(7), 0.0, end=True).velocity)
    assert robot.error == ""
    assert servo.is_finished
    assert np.abs(robot.command.velocity).max() < 1e-6


def test_a_setpoint_is_reached_along_a_line():
    servo = VelocityServo()
    rates = run(servo, RATES, 100)
    np.testing.assert_allclose(rates[-1], RATES, atol=1e-9)
    share = rates @ RATES / (RATES @ RATES)
    np.testing.assert_allclose(rates, np.outer(share, RATES), atol=1e-9)
    assert (np.diff(share) > -1e-12).all()


def test_setpoints_beyond_the_limits_are_cut_back_together():
    servo = VelocityServo()
    rates = run(servo, 10 * RATES, 600)
    scale = np.min(LIMITER.velocity / np.abs(RATES))
    np.testing.assert_allclose(rates[-1], scale * RATES, atol=1e-9)


@pytest.mark.parametrize("age", [SETPOINT_EXPIRY + 1e-3, -1.0, math.inf])
def test_an_old_setpoint_ramps_to_zero(age):
    servo = VelocityServo()
    run(servo, RATES, 100)
    rates = run(servo, RATES, 200, age)
    speed = np.linalg.norm(rates, axis=1)
    assert (np.diff(speed) < 1e-9).all()
    assert speed[100] < 1e-9
    # All joints come to rest together: the path is the one that was checked.
    share = rates @ RATES / (RATES @ RATES)
    np.testing.assert_allclose(rates, np.outer(share, RATES), atol=1e-9)


def test_nothing_moves_again_before_a_request_for_rest():
    servo = VelocityServo()
    run(servo, RATES, 100)
    run(servo, RATES, 200, age=1.0)
    assert not np.abs(run(servo, RATES, 300)).max() > 1e-9
    run(servo, np.zeros(7), 1)
    assert np.abs(run(servo, RATES, 100)[-1] - RATES).max() < 1e-9


def test_a_motion_without_setpoints_ends_after_a_second():
    servo = VelocityServo()
    run(servo, RATES, 100)
    run(servo, RATES, 990, age=1.0)
    assert not servo.is_finished
    run(servo, RATES, 20, age=1.0)
    assert servo.is_finished
    assert servo.reason == "no setpoint for 1 s"


def test_what_is_no_number_ends_the_motion_by_a_ramp():
    servo = VelocityServo()
    run(servo, RATES, 100)
    rates = run(servo, np.where(RATES > 0.55, math.nan, RATES), 1)
    assert np.abs(rates[-1]).max() > 0.69
    assert servo.reason == "refused: a setpoint is not finite"
    run(servo, RATES, 200)
    assert servo.is_finished


class Leap:
    """An interpolator that has lost its mind."""

    def advance(self, target, smoothing):
        return [0.0] * 6 + [1.0]


def test_the_last_line_refuses_a_step_beyond_the_limits():
    servo = VelocityServo()
    servo._interpolator = Leap()  # type: ignore
    command = servo.step(RATES, 0.0)
    assert not command.velocity.any()
    assert servo.is_finished
    assert servo.reason.startswith(
        "refused: joint 7: acceleration 1000 rad/s^2 beyond 20"
    )


def test_violations_are_named():
    fast = JointCommand(PANDA.velocity * 1.01, np.zeros(7))
    assert "joint 1: velocity" in violation(fast, fast)
    hard = JointCommand(np.zeros(7), np.full(7, 9.0))
    assert "joint 2: acceleration 9 rad/s^2" in violation(hard, hard)
    soft = JointCommand(np.zeros(7), np.full(7, 7.4))
    assert "joint 2: jerk 7400 rad/s^3" in violation(soft, AT_REST)
    nothing = JointCommand(np.full(7, math.nan), np.zeros(7))
    assert "joint 1: velocity nan" in violation(nothing, AT_REST)
    assert violation(next_command(RATES, AT_REST), AT_REST) == ""


def test_a_staircase_at_100_hz_is_smoother_than_by_the_limiter():
    """Jerk, root of the mean square: a quarter of libfranka's filter's."""
    servo, limited = VelocityServo(), AT_REST
    ours, theirs = [], []
    for tick in range(3000):
        setpoint = RATES * math.sin(2e-3 * (tick - tick % 10))
        ours.append(servo.step(setpoint, 0.0).velocity)
        limited = next_command(setpoint, limited)
        theirs.append(limited.velocity)
    jerk = [np.diff(v, 2, axis=0) / TICK**2 for v in (ours, theirs)]
    rms = [np.sqrt(np.mean(j[500:] ** 2)) for j in jerk]
    assert rms[0] < rms[1] / 4


def test_a_braking_ramp_is_hardly_longer_than_by_libfrankas_filter():
    """The ramp as the supervisor sends it; the lag is 4 ms longer."""
    servo, limited = VelocityServo(), JointCommand(RATES, np.zeros(7))
    run(servo, RATES, 100)
    ours, theirs = np.zeros(7), np.zeros(7)
    for tick in range(200):
        setpoint = RATES * max(0.0, 1 - (1 + tick // 10) / 8)
        ours += TICK * servo.step(setpoint, 0.0).velocity
        limited = next_command(setpoint, limited)
        theirs += TICK * limited.velocity
    assert not np.abs(servo.command.velocity).max() > 1e-6
    assert (np.abs(ours) < np.abs(theirs) + 5e-3 * np.abs(RATES)).all()


def test_twenty_lost_packets_abort_nineteen_do_not():
    servo, robot = VelocityServo(), FciRules()
    robot.begin()
    for velocity in run(servo, RATES, 100):
        robot.step(NOWHERE, velocity)
    for _ in range(19):
        robot.step(NOWHERE, None)
    assert robot.mode == RobotMode.MOVE
    assert robot.success_rate == pytest.approx(0.81)
    np.testing.assert_allclose(robot.command.velocity, RATES, atol=1e-9)
    robot.step(NOWHERE, None)
    assert robot.mode == RobotMode.REFLEX
    assert robot.error == "communication_constraints_violation"
    assert robot.success_rate == 0.0
    for _ in range(300):
        robot.step(NOWHERE, RATES)
    assert not np.abs(robot.command.velocity).max() > 1e-6
